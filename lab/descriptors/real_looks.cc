#include "lab/descriptors/real_looks.h"

#include <Eigen/Geometry>

#include "core/require.h"
#include "lab/descriptors/look_collector.h"

namespace cairn {

void RealLooksOptions::Validate() const {
  RequireOption(max_distance_px > 0.0, "looks.max_distance_px must be positive");
  RequireOption(max_log2_size_ratio > 0.0, "looks.max_log2_size_ratio must be positive");
  RequireOption(max_orientation_rad > 0.0, "looks.max_orientation_rad must be positive");
  RequireOption(max_landmarks >= 1, "looks.max_landmarks must be at least 1");
}

RealLooks LooksAtReconstruction(const Reconstruction& reconstruction,
                                const RealLooksOptions& options) {
  options.Validate();
  std::vector<PosedImage> images;
  Eigen::Vector3d down = Eigen::Vector3d::Zero();
  for (const ReconImage& image : reconstruction.images) {
    images.push_back({.camera = &reconstruction.cameras[image.camera_idx],
                      .cam_from_world = image.cam_from_world,
                      .center_in_world = image.cam_from_world.Inverse().translation,
                      .features = image.features.Unpacked()});
    down += image.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitY();
  }
  LookCollector collector(images, options);
  const std::vector<ReconLandmark>& landmarks = reconstruction.landmarks;
  for (size_t i = 0; i < landmarks.size(); i += StepFor(landmarks.size(), options.max_landmarks)) {
    const ReconObservation& first = landmarks[i].observations.front();
    const PosedImage& image = images[first.image_idx];
    const Keypoint& keypoint = image.features.keypoints[first.keypoint_idx];
    const Eigen::Vector3d& x_in_world = landmarks[i].x_in_world;
    const double depth = DepthOf(image, x_in_world);
    collector.Add(
        {.x_in_world = x_in_world,
         .axes_from_world = AxesAbout(image.center_in_world - x_in_world, -down.normalized()),
         .along_in_world = Eigen::Vector3d::Zero(),
         .size = keypoint.scale_px * depth / image.camera->focal_px(),
         .depth = depth,
         .orientation_rad = keypoint.orientation_rad},
        first.image_idx, first.keypoint_idx, [](int) { return true; });
  }
  return collector.Finish();
}

}  // namespace cairn
