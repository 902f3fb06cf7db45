#include "engine/voting/candidate_support.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cairn {

namespace {

// Where a landmark lies as seen along a ray from the candidate.
struct Sighting {
  double distance_m = 0.0;  // To the landmark.
  double offset_m = 0.0;    // Of the landmark from the ray.
  bool is_ahead = false;
};

Sighting Sight(const Eigen::Vector3d& direction, const Eigen::Vector3d& to_landmark) {
  return {to_landmark.norm(), direction.cross(to_landmark).norm(),
          direction.dot(to_landmark) > 0.0};
}

// The same by horizontal components alone.
Sighting SightHorizontally(const Eigen::Vector3d& direction, const Eigen::Vector3d& to_landmark) {
  const Eigen::Vector3d level_direction(direction.x(), direction.y(), 0.0);
  const double horizontal = std::max(1e-9, level_direction.norm());
  Sighting sighting =
      Sight(level_direction / horizontal, Eigen::Vector3d(to_landmark.x(), to_landmark.y(), 0.0));
  sighting.distance_m /= horizontal;
  return sighting;
}

}  // namespace

PoseCandidate SupportedCandidate(const std::vector<VoteRay>& rays,
                                 const Eigen::Vector3d& center_in_anchor, double yaw_rad,
                                 const VotingOptions& options) {
  PoseCandidate candidate;
  candidate.center_in_anchor = center_in_anchor;
  candidate.yaw_rad = yaw_rad;
  const double cos_yaw = std::cos(yaw_rad), sin_yaw = std::sin(yaw_rad);
  const double min_cosine = std::cos(options.max_azimuth_difference_rad);
  const auto sight = options.filter == OutlierFilter::kVoting3d ? SightHorizontally : Sight;
  double best_gain = 0.0;  // Of the current keypoint.
  for (size_t i = 0; i < rays.size(); ++i) {
    const VoteRay& ray = rays[i];
    if (i > 0 && rays[i - 1].keypoint_idx != ray.keypoint_idx) {
      candidate.score += best_gain;
      best_gain = 0.0;
    }
    const auto turn = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d {
      return {cos_yaw * v.x() - sin_yaw * v.y(), sin_yaw * v.x() + cos_yaw * v.y(), v.z()};
    };
    const Eigen::Vector3d direction = turn(ray.direction_in_level);
    const Eigen::Vector3d to_landmark =
        ray.x_in_anchor - center_in_anchor - turn(ray.origin_in_level);
    const Sighting seen = sight(direction, to_landmark);
    const double tolerance_m =
        options.direction_tolerance_rad * seen.distance_m + options.cell_xy_m;
    if (seen.distance_m < ray.min_distance_m - options.cell_xy_m ||
        seen.distance_m > ray.max_distance_m + options.cell_xy_m || seen.offset_m >= tolerance_m ||
        !seen.is_ahead || !AzimuthFits(ray, direction.head<2>(), min_cosine)) {
      continue;
    }
    candidate.correspondences.push_back(ray.correspondence_idx);
    best_gain = std::max(best_gain, 1.0 - std::pow(seen.offset_m / tolerance_m, 2));
  }
  candidate.score += best_gain;
  std::sort(candidate.correspondences.begin(), candidate.correspondences.end());
  return candidate;
}

}  // namespace cairn
