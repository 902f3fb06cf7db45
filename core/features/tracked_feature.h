// A feature that a tracker follows from image to image.
#ifndef CAIRN_CORE_FEATURES_TRACKED_FEATURE_H_
#define CAIRN_CORE_FEATURES_TRACKED_FEATURE_H_

#include <Eigen/Core>
#include <cstdint>

namespace cairn::fusion {

// A feature seen in one frame. Features with the same id in different frames show the same point.
struct TrackedFeature {
  uint64_t track_id = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

}  // namespace cairn::fusion

#endif  // CAIRN_CORE_FEATURES_TRACKED_FEATURE_H_
