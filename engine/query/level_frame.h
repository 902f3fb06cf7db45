// The gravity-aligned camera frame `level`.
#ifndef CAIRN_ENGINE_QUERY_LEVEL_FRAME_H_
#define CAIRN_ENGINE_QUERY_LEVEL_FRAME_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace cairn {

// Returns the rotation level_from_cam that maps `down_in_cam` (not zero, of any length) to (0, 0,
// -1). The x axis of level is the horizontal part of the viewing direction (0, 0, 1). If the
// viewing direction is within 0.06 degrees of the vertical, the x axis is the horizontal part of
// the image's y axis.
Eigen::Quaterniond LevelFromCam(const Eigen::Vector3d& down_in_cam);

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_LEVEL_FRAME_H_
