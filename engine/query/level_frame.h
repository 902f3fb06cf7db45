// The gravity-aligned camera frame `level`.
#ifndef CAIRN_ENGINE_QUERY_LEVEL_FRAME_H_
#define CAIRN_ENGINE_QUERY_LEVEL_FRAME_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace cairn {

// Rotation level_from_cam that turns `down_in_cam` (not zero; need not be of unit length) into
// (0, 0, -1). The x axis of level is the horizontal part of the viewing direction (0, 0, 1), or, if
// that is within 0.06 degrees of the vertical, of the image's y axis.
Eigen::Quaterniond LevelFromCam(const Eigen::Vector3d& down_in_cam);

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_LEVEL_FRAME_H_
