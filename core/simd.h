// Wide instructions, chosen at run time: the one way in which Cairn's hot loops are vectorized.
//
// A loop is written plainly, or, where the compiler does not see the vectors in it, over Lanes; one
// of the macros below compiles it for several instruction sets, and the loader takes the best that
// the processor has. Intrinsics are for what the compiler cannot express; they live in
// engine/index (see intrinsics.h there), beside a plain version that tests compare.
#ifndef CAIRN_CORE_SIMD_H_
#define CAIRN_CORE_SIMD_H_

namespace cairn {
namespace internal {

template <typename T, int kCount>
struct LanesOf {
  typedef T Type __attribute__((vector_size(kCount * sizeof(T))));
};

}  // namespace internal

// `kCount` numbers in one vector register, or in several where registers are narrower. Arithmetic
// is by lane; comparisons give integer lanes of 0 and -1. `kCount` is a power of two.
template <typename T, int kCount>
using Lanes = typename internal::LanesOf<T, kCount>::Type;

}  // namespace cairn

// Before a function. CAIRN_VECTOR_CLONES compiles it for AVX-512, AVX2 and baseline x86-64;
// floating point results may differ in the last bit between processors (fused multiply-add).
// CAIRN_EXACT_VECTOR_CLONES, for what is stored, compiles it for AVX2 without fused multiply-add
// and for the baseline: the same results on every processor. Neither macro has an effect on other
// compilers or processors, or under the thread sanitizer. That sanitizer crashes in code that runs
// as early as the choice.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define CAIRN_VECTOR_CLONES \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#define CAIRN_EXACT_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define CAIRN_VECTOR_CLONES
#define CAIRN_EXACT_VECTOR_CLONES
#endif

#endif  // CAIRN_CORE_SIMD_H_
