// Minimal problem: camera pose from two 2D-3D points and the direction of gravity (Sweeney et al.,
// "Efficient computation of absolute pose for gravity-aware augmented reality", 2015).
#ifndef CAIRN_ENGINE_POSE_GRAVITY_TWO_POINT_H_
#define CAIRN_ENGINE_POSE_GRAVITY_TWO_POINT_H_

#include <Eigen/Core>
#include <array>

namespace cairn {

// A pose with a known vertical axis. anchor_from_level is the rotation about z (up) by yaw =
// atan2(yaw_direction.y, yaw_direction.x).
struct LevelPose {
  Eigen::Vector2d yaw_direction;     // (cos yaw, sin yaw).
  Eigen::Vector3d center_in_anchor;  // Camera center.
};

// Finds the poses from which the landmarks `x_in_anchor` are seen along the unit vectors
// `bearings_in_level`, both at positive depth. The rays start at `origins_in_level`, which are zero
// except for cameras of a rig. Returns the number of poses, 0 to 2, and writes them to `solutions`.
// Solutions are exact: they reproduce both bearings up to rounding.
//
// For depths l1, l2, the height difference of the landmarks gives a line in the (l1, l2) plane,
//   o1z + l1 b1z - o2z - l2 b2z = X1z - X2z,
// and their distance gives a conic. The line is parametrized as closest point + s * direction,
// which treats both rays alike and requires only that one of the two bearings is not horizontal.
// There is no solution if
//   - both bearings are horizontal to 1e-9: heights carry no information and yaw is free;
//   - one landmark is vertically above the other to 1e-9 m: yaw is free;
//   - the bearings are equal and the origins are equal;
//   - no pose fits the points, or only a pose with a landmark behind the camera.
int SolveGravityTwoPoint(const std::array<Eigen::Vector3d, 2>& bearings_in_level,
                         const std::array<Eigen::Vector3d, 2>& x_in_anchor,
                         std::array<LevelPose, 2>* solutions,
                         const std::array<Eigen::Vector3d, 2>& origins_in_level = {
                             Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_GRAVITY_TWO_POINT_H_
