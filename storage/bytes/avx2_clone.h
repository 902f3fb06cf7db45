// One copy of a hot loop for AVX2 and one for any x86-64; private to storage.
#ifndef CAIRN_STORAGE_BYTES_AVX2_CLONE_H_
#define CAIRN_STORAGE_BYTES_AVX2_CLONE_H_

// Compiles a function for AVX2 and for baseline x86-64; the loader takes what the processor has.
// AVX2 alone brings no fused multiply-add, so results are the same on every processor. Without
// effect for other compilers, and under the thread sanitizer, which cannot run as early as that
// choice.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define CAIRN_AVX2_CLONE __attribute__((target_clones("avx2", "default")))
#else
#define CAIRN_AVX2_CLONE
#endif

#endif  // CAIRN_STORAGE_BYTES_AVX2_CLONE_H_
