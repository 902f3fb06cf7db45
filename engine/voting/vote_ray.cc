#include "engine/voting/vote_ray.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/keypoint_shape.h"

namespace cairn {
namespace {

// Narrows [min, max] to the distances at which the camera is within the height band.
void ClipToHeights(const SearchRegion& region, VoteRay* ray) {
  constexpr double kMinSlope = 1e-6;
  const double slope = ray->direction_in_level.z();
  const double z_m = ray->x_in_anchor.z() - ray->origin_in_level.z();
  const double above_min_m = z_m - region.min_z_m;
  const double above_max_m = z_m - region.max_z_m;
  if (std::abs(slope) < kMinSlope) {
    if (above_min_m < 0.0 || above_max_m > 0.0) {
      ray->max_distance_m = -1.0;
    }
    return;
  }
  const auto [low, high] = std::minmax({above_min_m / slope, above_max_m / slope});
  ray->min_distance_m = std::max(ray->min_distance_m, low);
  ray->max_distance_m = std::min(ray->max_distance_m, high);
}

void ClipToSize(double predicted_distance_m, double factor, VoteRay* ray) {
  ray->min_distance_m = std::max(ray->min_distance_m, predicted_distance_m / factor);
  ray->max_distance_m = std::min(ray->max_distance_m, predicted_distance_m * factor);
}

}  // namespace

std::vector<VoteRay> MakeVoteRays(const QueryContext& query,
                                  const std::vector<Correspondence>& correspondences,
                                  const VotingOptions& options) {
  constexpr double kMinDistanceM = 0.3;
  std::vector<VoteRay> rays;
  rays.reserve(correspondences.size());
  for (size_t i = 0; i < correspondences.size(); ++i) {
    const Correspondence& match = correspondences[i];
    const Eigen::Vector3d& ray_in_cam = query.rays_in_cam[match.keypoint_idx];
    if (ray_in_cam.isZero()) {
      continue;
    }
    VoteRay ray;
    ray.correspondence_idx = static_cast<int>(i);
    ray.keypoint_idx = match.keypoint_idx;
    ray.x_in_anchor = match.x_in_anchor;
    ray.direction_in_level = *query.level_from_cam * ray_in_cam;
    if (query.is_rig()) {
      ray.origin_in_level = *query.level_from_cam * query.OriginInCam(match.keypoint_idx);
    }
    ray.horizontal = ray.direction_in_level.head<2>().norm();
    ray.view_azimuth = {std::cos(match.azimuth_rad), std::sin(match.azimuth_rad)};
    ray.min_distance_m = kMinDistanceM;
    ray.max_distance_m = options.max_distance_m;
    const Keypoint& keypoint = query.keypoints[match.keypoint_idx];
    if (options.max_distance_factor > 0.0 && match.size_m > 0.0f && HasScale(keypoint)) {
      ClipToSize(match.size_m * query.CameraOf(match.keypoint_idx).focal_px() / keypoint.scale_px,
                 options.max_distance_factor, &ray);
    }
    ClipToHeights(query.region, &ray);
    if (ray.min_distance_m <= ray.max_distance_m) {
      rays.push_back(ray);
    }
  }
  const auto by_keypoint = [](const VoteRay& a, const VoteRay& b) {
    return a.keypoint_idx < b.keypoint_idx;
  };
  if (!std::is_sorted(rays.begin(), rays.end(), by_keypoint)) {
    std::stable_sort(rays.begin(), rays.end(), by_keypoint);
  }
  return rays;
}

}  // namespace cairn
