// A separate file, because the build disables the compiler's vectorization for this file only.
#include "engine/pose/score_block.h"

namespace cairn {
namespace {

template <bool kHasOrigins>
float ScoreOneByOne(const ScoreBlockInput& in, const FloatModel& m, float* __restrict gains) {
  float sum = 0.0f;
  for (int i = 0; i < kScoreBlock; ++i) {
    gains[i] = ObservationGain<kHasOrigins>(in, m, i);
    sum += gains[i];
  }
  return sum;
}

}  // namespace

float ScoreBlockPlain(const ScoreBlockInput& in, const FloatModel& m, float* __restrict gains) {
  return in.origin_x != nullptr ? ScoreOneByOne<true>(in, m, gains)
                                : ScoreOneByOne<false>(in, m, gains);
}

}  // namespace cairn
