#include "engine/voting/candidate_support.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cairn {

PoseCandidate SupportedCandidate(const std::vector<VoteRay>& rays,
                                 const Eigen::Vector3d& center_in_anchor, double yaw_rad,
                                 const VotingOptions& options) {
  PoseCandidate candidate;
  candidate.center_in_anchor = center_in_anchor;
  candidate.yaw_rad = yaw_rad;
  const double cos_yaw = std::cos(yaw_rad), sin_yaw = std::sin(yaw_rad);
  const double min_cosine = std::cos(options.max_azimuth_difference_rad);
  double best_gain = 0.0;  // Of the current keypoint.
  for (size_t i = 0; i < rays.size(); ++i) {
    const VoteRay& ray = rays[i];
    if (i > 0 && rays[i - 1].keypoint_idx != ray.keypoint_idx) {
      candidate.score += best_gain;
      best_gain = 0.0;
    }
    const Eigen::Vector3d to_landmark = ray.x_in_anchor - center_in_anchor;
    const double distance_m = to_landmark.norm();
    if (distance_m < ray.min_distance_m - options.cell_xy_m ||
        distance_m > ray.max_distance_m + options.cell_xy_m) {
      continue;
    }
    const Eigen::Vector3d& d = ray.direction_in_level;
    const Eigen::Vector3d direction(cos_yaw * d.x() - sin_yaw * d.y(),
                                    sin_yaw * d.x() + cos_yaw * d.y(), d.z());
    const double offset_m = direction.cross(to_landmark).norm();  // Of the landmark from the ray.
    const double tolerance_m = options.direction_tolerance_rad * distance_m + options.cell_xy_m;
    if (offset_m >= tolerance_m || direction.dot(to_landmark) <= 0.0 ||
        !AzimuthFits(ray, direction.head<2>(), min_cosine)) {
      continue;
    }
    candidate.correspondences.push_back(ray.correspondence_idx);
    best_gain = std::max(best_gain, 1.0 - std::pow(offset_m / tolerance_m, 2));
  }
  candidate.score += best_gain;
  std::sort(candidate.correspondences.begin(), candidate.correspondences.end());
  return candidate;
}

}  // namespace cairn
