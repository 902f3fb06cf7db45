// A camera of a rig.
#ifndef CAIRN_CORE_RIG_CAMERA_H_
#define CAIRN_CORE_RIG_CAMERA_H_

#include "core/camera.h"
#include "core/features.h"
#include "core/rigid3.h"

namespace cairn {

// Another camera of a rig and its features, seen at the same instant.
struct RigCamera {
  static constexpr double kMaxOffsetM = 100.0;  // From the query's own camera.
  static constexpr int kMaxOthers = 7;          // Cameras besides the query's own.

  Camera camera;
  Rigid3d cam_from_first;  // From the frame of the query's own camera to this camera's frame.
  FeatureSet features;     // In the same descriptor space as the query's own features.
};

}  // namespace cairn

#endif  // CAIRN_CORE_RIG_CAMERA_H_
