// Compiles one copy of a hot loop for AVX2 and one for any x86-64. Private to storage.
#ifndef CAIRN_STORAGE_BYTES_AVX2_CLONE_H_
#define CAIRN_STORAGE_BYTES_AVX2_CLONE_H_

// Compiles a function twice, for AVX2 and for baseline x86-64; the loader picks the copy that the
// processor supports. AVX2 alone has no fused multiply-add, so results are the same on every
// processor. The macro is empty for other compilers, and under the thread sanitizer, which is not
// initialised yet when the loader picks.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define CAIRN_AVX2_CLONE __attribute__((target_clones("avx2", "default")))
#else
#define CAIRN_AVX2_CLONE
#endif

#endif  // CAIRN_STORAGE_BYTES_AVX2_CLONE_H_
