#include "core/simd.h"
#include "engine/pose/score_block.h"

namespace cairn {
namespace {

template <bool kHasOrigins>
[[gnu::always_inline]] inline float ScoreByLanes(const ScoreBlockInput& in, const FloatModel& m,
                                                 float* __restrict gains) {
  constexpr int kNumLanes = 16;
  float lane_gain[kNumLanes] = {};
  for (int begin = 0; begin < kScoreBlock; begin += kNumLanes) {
    for (int lane = 0; lane < kNumLanes; ++lane) {
      const float gain = ObservationGain<kHasOrigins>(in, m, begin + lane);
      gains[begin + lane] = gain;
      lane_gain[lane] += gain;
    }
  }
  float sum = 0.0f;
  for (int lane = 0; lane < kNumLanes; ++lane) {
    sum += lane_gain[lane];
  }
  return sum;
}

CAIRN_VECTOR_CLONES
float ScoreWithOrigins(const ScoreBlockInput& in, const FloatModel& m, float* __restrict gains) {
  return ScoreByLanes<true>(in, m, gains);
}

CAIRN_VECTOR_CLONES
float ScoreWithoutOrigins(const ScoreBlockInput& in, const FloatModel& m, float* __restrict gains) {
  return ScoreByLanes<false>(in, m, gains);
}

}  // namespace

float ScoreBlockVectorized(const ScoreBlockInput& in, const FloatModel& m,
                           float* __restrict gains) {
  return in.origin_x != nullptr ? ScoreWithOrigins(in, m, gains)
                                : ScoreWithoutOrigins(in, m, gains);
}

}  // namespace cairn
