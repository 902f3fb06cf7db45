#include "cli/demo/street/posed_features.h"

namespace cairn {

PosedFeatures MakePosedFeatures(const Camera& camera, const FeatureSet& features,
                                const Rigid3d& cam_from_world) {
  const Rigid3d world_from_cam = cam_from_world.Inverse();
  PosedFeatures posed = {&camera, &features, cam_from_world, world_from_cam.translation, {}};
  posed.rays_in_world.reserve(features.keypoints.size());
  for (const Keypoint& keypoint : features.keypoints) {
    const auto ray_in_cam = camera.Unproject({keypoint.x_px, keypoint.y_px});
    posed.rays_in_world.push_back(ray_in_cam
                                      ? Eigen::Vector3d(world_from_cam.rotation * *ray_in_cam)
                                      : Eigen::Vector3d(Eigen::Vector3d::Zero()));
  }
  return posed;
}

}  // namespace cairn
