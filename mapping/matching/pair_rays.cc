#include "mapping/matching/pair_rays.h"

#include "core/scene/triangulate.h"

namespace cairn {

std::optional<Eigen::Vector3d> RaySource::RayOf(int keypoint_idx) const {
  const Keypoint& keypoint = photo.keypoints[keypoint_idx];
  return camera.Unproject({keypoint.x_px, keypoint.y_px});
}

double RaySource::SigmaRad(int keypoint_idx) const {
  return sigma_factor * KeypointSigmaPx(photo.keypoints[keypoint_idx].scale_px) / camera.focal_px();
}

PairRays MakePairRays(const RaySource& a, const RaySource& b,
                      std::span<const FeatureMatch> matches) {
  PairRays result;
  for (size_t i = 0; i < matches.size(); ++i) {
    const auto ray_a = a.RayOf(matches[i].a_idx);
    const auto ray_b = b.RayOf(matches[i].b_idx);
    if (ray_a && ray_b) {
      result.rays.push_back(
          {*ray_a, *ray_b, a.SigmaRad(matches[i].a_idx), b.SigmaRad(matches[i].b_idx)});
      result.match_of_ray.push_back(static_cast<int>(i));
    }
  }
  return result;
}

}  // namespace cairn
