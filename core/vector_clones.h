// Compiles one copy of a hot loop per vector width; the copy is chosen at program start.
#ifndef CAIRN_CORE_VECTOR_CLONES_H_
#define CAIRN_CORE_VECTOR_CLONES_H_

// Put this macro before a function with plain loops that the compiler vectorises. The function is
// compiled for AVX-512, AVX2 and baseline x86-64, and the loader picks the best copy that the
// processor supports. Results may differ in the last bit between processors (fused multiply-add).
// The macro is empty for other compilers and processors, and under the thread sanitizer, which
// crashes in code that runs as early as the loader's choice.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define CAIRN_VECTOR_CLONES \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define CAIRN_VECTOR_CLONES
#endif

#endif  // CAIRN_CORE_VECTOR_CLONES_H_
