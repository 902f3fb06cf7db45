// Intrinsics of x86-64, the instruction sets that the kernels use, and whether the processor has
// them; private to the kernels. A function that is compiled for a set, by the macro of its name,
// runs only where the Has... of its name is true.
#ifndef CAIRN_ENGINE_INDEX_INTRINSICS_H_
#define CAIRN_ENGINE_INDEX_INTRINSICS_H_

#if defined(__x86_64__)

// GCC 12 takes the deliberately undefined registers of its own AVX-512 header for a mistake (bug
// 105593).
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#include <immintrin.h>

#define CAIRN_AVX2 __attribute__((target("avx2")))
#define CAIRN_AVX512VNNI __attribute__((target("avx512f,avx512bw,avx512vl,avx512vnni")))
#define CAIRN_AVX512VBMI __attribute__((target("avx512f,avx512bw,avx512vl,avx512vnni,avx512vbmi")))

namespace cairn {

inline bool HasAvx2() { return __builtin_cpu_supports("avx2"); }
inline bool HasAvx512Vnni() {
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512vnni");
}
inline bool HasAvx512Vbmi() { return HasAvx512Vnni() && __builtin_cpu_supports("avx512vbmi"); }

}  // namespace cairn

#endif

#endif  // CAIRN_ENGINE_INDEX_INTRINSICS_H_
