// The arithmetic of consensus: the gains of a pose for 64 observations.
#ifndef CAIRN_ENGINE_POSE_SCORE_BLOCK_H_
#define CAIRN_ENGINE_POSE_SCORE_BLOCK_H_

#include <algorithm>

namespace cairn {

inline constexpr int kScoreBlock = 64;

// A pose [R | t] relative to the origin of the observations, and the addition to squared
// thresholds.
struct FloatModel {
  float r[9];  // Row-major.
  float t[3];
  float extra_sq_rad;
};

// kScoreBlock observations; see ConsensusSet.
struct ScoreBlockInput {
  const float *ray_x, *ray_y, *ray_z;
  const float *origin_x, *origin_y, *origin_z;  // Null if all rays start at the camera.
  const float *point_x, *point_y, *point_z;
  const float *sq_threshold, *sq_sigma;
};

// Writes the gains of a block and returns their sum. ScoreBlockVectorized and ScoreBlockPlain do
// the same arithmetic. They differ in the order of the sums and, on processors with fused
// multiply-add, in the last bits. ScoreBlockVectorized scores sixteen, eight or four observations
// at a time, chosen at program start.
float ScoreBlockVectorized(const ScoreBlockInput& in, const FloatModel& m, float* __restrict gains);
// Scores one observation at a time; the reference for tests and measurements.
float ScoreBlockPlain(const ScoreBlockInput& in, const FloatModel& m, float* __restrict gains);

// The gain of observation i, as defined at ConsensusSet.
template <bool kHasOrigins>
[[gnu::always_inline]] inline float ObservationGain(const ScoreBlockInput& in, const FloatModel& m,
                                                    int i) {
  const float x = in.point_x[i], y = in.point_y[i], z = in.point_z[i];
  float px = m.r[0] * x + m.r[1] * y + m.r[2] * z + m.t[0];
  float py = m.r[3] * x + m.r[4] * y + m.r[5] * z + m.t[1];
  float pz = m.r[6] * x + m.r[7] * y + m.r[8] * z + m.t[2];
  if constexpr (kHasOrigins) {
    px -= in.origin_x[i], py -= in.origin_y[i], pz -= in.origin_z[i];
  }
  const float cross_x = in.ray_y[i] * pz - in.ray_z[i] * py;
  const float cross_y = in.ray_z[i] * px - in.ray_x[i] * pz;
  const float cross_z = in.ray_x[i] * py - in.ray_y[i] * px;
  // The numerator and the denominator of (sin e / t)^2 are both multiplied by the squared distance.
  const float sq_sine = cross_x * cross_x + cross_y * cross_y + cross_z * cross_z;
  const float sq_distance = px * px + py * py + pz * pz;
  const float sq_base = sq_distance * in.sq_threshold[i];
  const float sq_widened = std::min(sq_base + 9.0f * in.sq_sigma[i], 4.0f * sq_base);
  const float ratio = sq_sine / (sq_widened + sq_distance * m.extra_sq_rad);
  const float depth = in.ray_x[i] * px + in.ray_y[i] * py + in.ray_z[i] * pz;
  float gain = 1.0f - ratio;
  gain = gain > 0.0f ? gain : 0.0f;  // 0 also for NaN, when the landmark is the camera center.
  return depth > 0.0f ? gain : 0.0f;
}

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_SCORE_BLOCK_H_
