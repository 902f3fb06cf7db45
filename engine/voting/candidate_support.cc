#include "engine/voting/candidate_support.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "engine/vector_clones.h"

namespace cairn {
namespace {

// A candidate and how far off a ray may be.
struct SupportTest {
  double x, y, z;  // Camera centre, relative to that of the rays.
  double cos_yaw, sin_yaw;
  double min_cosine;     // Of the azimuth difference.
  double tolerance_rad;  // Of directions.
  double slack_m;        // Of distances.
};

// 1 - (e / t)^2 of ray i, or 0 if it does not agree.
template <bool kIn3d, bool kHasOrigins>
[[gnu::always_inline]] inline double RayGain(const RayPointers<double>& rays,
                                             const SupportTest& test, int i) {
  const double cos_yaw = test.cos_yaw, sin_yaw = test.sin_yaw;
  double dx = cos_yaw * rays.direction_x[i] - sin_yaw * rays.direction_y[i];
  double dy = sin_yaw * rays.direction_x[i] + cos_yaw * rays.direction_y[i];
  double dz = rays.direction_z[i];
  double x = rays.x[i] - test.x, y = rays.y[i] - test.y, z = rays.z[i] - test.z;
  if constexpr (kHasOrigins) {
    x -= cos_yaw * rays.origin_x[i] - sin_yaw * rays.origin_y[i];
    y -= sin_yaw * rays.origin_x[i] + cos_yaw * rays.origin_y[i];
    z -= rays.origin_z[i];
  }
  const double cosine = -(dx * rays.view_x[i] + dy * rays.view_y[i]);
  const bool azimuth_fits = cosine >= test.min_cosine * rays.horizontal[i];
  double distance_scale = 1.0;
  if constexpr (kIn3d) {
    distance_scale = 1.0 / std::max(1e-9, rays.horizontal[i]);
    dx *= distance_scale, dy *= distance_scale, dz = 0.0, z = 0.0;
  }
  const double cross_x = dy * z - dz * y, cross_y = dz * x - dx * z, cross_z = dx * y - dy * x;
  const double sq_offset = cross_x * cross_x + cross_y * cross_y + cross_z * cross_z;
  const double distance_m = distance_scale * std::sqrt(x * x + y * y + z * z);
  const double tolerance_m = test.tolerance_rad * distance_m + test.slack_m;
  const double gain = 1.0 - sq_offset / (tolerance_m * tolerance_m);
  const bool agrees = azimuth_fits & (dx * x + dy * y + dz * z > 0.0) &
                      (distance_m >= rays.min_distance_m[i] - test.slack_m) &
                      (distance_m <= rays.max_distance_m[i] + test.slack_m) & (gain > 0.0);
  return agrees ? gain : 0.0;
}

template <bool kIn3d, bool kHasOrigins>
[[gnu::always_inline]] inline void AllGains(const RayPointers<double>& rays,
                                            const SupportTest& test, int size,
                                            double* __restrict gains) {
  for (int i = 0; i < size; ++i) {
    gains[i] = RayGain<kIn3d, kHasOrigins>(rays, test, i);
  }
}

CAIRN_VECTOR_CLONES
void RayGains(const RayPointers<double>& pointers, const SupportTest& test, bool in_3d,
              bool has_origins, int size, double* __restrict gains) {
  const RayPointers<double> rays = pointers;
  if (in_3d) {
    has_origins ? AllGains<true, true>(rays, test, size, gains)
                : AllGains<true, false>(rays, test, size, gains);
  } else {
    has_origins ? AllGains<false, true>(rays, test, size, gains)
                : AllGains<false, false>(rays, test, size, gains);
  }
}

}  // namespace

PoseCandidate SupportedCandidate(const RayArrays<double>& rays,
                                 const Eigen::Vector3d& center_in_anchor, double yaw_rad,
                                 const VotingOptions& options) {
  PoseCandidate candidate;
  candidate.center_in_anchor = center_in_anchor;
  candidate.yaw_rad = yaw_rad;
  const Eigen::Vector3d center = center_in_anchor - rays.center_in_anchor;
  const SupportTest test = {center.x(),
                            center.y(),
                            center.z(),
                            std::cos(yaw_rad),
                            std::sin(yaw_rad),
                            std::cos(options.max_azimuth_difference_rad),
                            options.direction_tolerance_rad,
                            options.cell_xy_m};
  std::vector<double> gains(rays.padded_size());
  RayGains(RayPointers<double>(rays), test, options.filter == OutlierFilter::kVoting3d,
           rays.has_origins(), rays.padded_size(), gains.data());

  double best_gain = 0.0;  // Of the current keypoint.
  for (int i = 0; i < rays.num_rays; ++i) {
    if (i > 0 && rays.voters[i - 1] != rays.voters[i]) {
      candidate.score += best_gain;
      best_gain = 0.0;
    }
    if (gains[i] > 0.0) {
      candidate.correspondences.push_back(rays.correspondence_idxs[i]);
      best_gain = std::max(best_gain, gains[i]);
    }
  }
  candidate.score += best_gain;
  std::sort(candidate.correspondences.begin(), candidate.correspondences.end());
  return candidate;
}

}  // namespace cairn
