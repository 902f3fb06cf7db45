#include "mapping/matching/pair_rays.h"

#include <Eigen/LU>

#include "core/scene/triangulate.h"

namespace cairn {

std::optional<Eigen::Vector3d> RaySource::RayOf(int keypoint_idx) const {
  const Keypoint& keypoint = photo.keypoints[keypoint_idx];
  return camera.Unproject({keypoint.x_px, keypoint.y_px});
}

std::optional<RaySpread> RaySource::SpreadOf(int keypoint_idx, const Eigen::Vector3d& ray) const {
  Eigen::Matrix<double, 2, 3> pixel_by_ray;
  if (!camera.ProjectWithJacobian(ray, &pixel_by_ray)) {
    return std::nullopt;
  }
  const double sigma_px = sigma_factor * KeypointSigmaPx(photo.keypoints[keypoint_idx].scale_px);
  const RaySpread plane = EvenSpread(ray, 1.0);
  const Eigen::Matrix2d pixel_by_shift = pixel_by_ray * plane;
  return plane * (sigma_px * pixel_by_shift.inverse());
}

PairRays MakePairRays(const RaySource& a, const RaySource& b,
                      std::span<const FeatureMatch> matches) {
  PairRays result;
  for (size_t i = 0; i < matches.size(); ++i) {
    const auto ray_a = a.RayOf(matches[i].a_idx);
    const auto ray_b = b.RayOf(matches[i].b_idx);
    const auto spread_a = ray_a ? a.SpreadOf(matches[i].a_idx, *ray_a) : std::nullopt;
    const auto spread_b = ray_b ? b.SpreadOf(matches[i].b_idx, *ray_b) : std::nullopt;
    if (spread_a && spread_b) {
      result.rays.push_back({*ray_a, *ray_b, *spread_a, *spread_b});
      result.match_of_ray.push_back(static_cast<int>(i));
    }
  }
  return result;
}

}  // namespace cairn
