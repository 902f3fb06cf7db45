// Apart from the vectorised form because the build keeps the compiler from vectorising this file.
#include "engine/pose/score_block.h"

namespace cairn {

float ScoreBlockPlain(const ScoreBlockInput& in, const FloatModel& m, float* __restrict gains) {
  float sum = 0.0f;
  for (int i = 0; i < kScoreBlock; ++i) {
    gains[i] = ObservationGain(in, m, i);
    sum += gains[i];
  }
  return sum;
}

}  // namespace cairn
