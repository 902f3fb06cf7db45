// The features of an image with a known pose.
#ifndef CAIRN_CLI_DEMO_STREET_POSED_FEATURES_H_
#define CAIRN_CLI_DEMO_STREET_POSED_FEATURES_H_

#include <Eigen/Core>
#include <vector>

#include "core/camera.h"
#include "core/features.h"
#include "core/rigid3.h"

namespace cairn {

// Does not own the camera or the features. Immutable after construction; safe to use from any
// thread.
struct PosedFeatures {
  const Camera* camera = nullptr;
  const FeatureSet* features = nullptr;
  Rigid3d cam_from_world;
  Eigen::Vector3d center_in_world = Eigen::Vector3d::Zero();
  // Unit viewing rays of the keypoints. Zero if the lens model cannot be inverted at the keypoint.
  std::vector<Eigen::Vector3d> rays_in_world;
};

PosedFeatures MakePosedFeatures(const Camera& camera, const FeatureSet& features,
                                const Rigid3d& cam_from_world);

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_STREET_POSED_FEATURES_H_
