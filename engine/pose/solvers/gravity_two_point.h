// Minimal problem: camera pose from two 2D-3D points and the direction of gravity (Sweeney et al.,
// "Efficient computation of absolute pose for gravity-aware augmented reality", 2015).
#ifndef CAIRN_ENGINE_POSE_SOLVERS_GRAVITY_TWO_POINT_H_
#define CAIRN_ENGINE_POSE_SOLVERS_GRAVITY_TWO_POINT_H_

#include <Eigen/Core>
#include <array>

namespace cairn {

// A pose with the vertical axis known: anchor_from_level is the rotation about z (up) by
// yaw = atan2(yaw_direction.y, yaw_direction.x).
struct LevelPose {
  Eigen::Vector2d yaw_direction;     // (cos yaw, sin yaw).
  Eigen::Vector3d center_in_anchor;  // Camera centre.
};

// Finds the poses from which the landmarks `x_in_anchor` are seen along the unit vectors
// `bearings_in_level`, both at positive depth; the rays start at `origins_in_level`, zero but for
// the cameras of a rig. Returns their number, 0 to 2, and writes them to
// `solutions`; a solution is exact: it reproduces both bearings to rounding.
//
// With depths l1, l2 the height difference of the landmarks gives a line in the (l1, l2) plane,
//   o1z + l1 b1z - o2z - l2 b2z = X1z - X2z,
// and their distance a conic; the line is taken in the form closest point + s * direction, which
// has no preferred ray and only asks that one of the two bearings leaves the horizontal plane.
// There is no solution if
//   - both bearings are horizontal to 1e-9: heights then say nothing and yaw is free;
//   - the landmarks stand above one another to 1e-9 m: yaw is free;
//   - the bearings are equal and the origins are too;
//   - the points fit no pose, or only one with a landmark behind the camera.
int SolveGravityTwoPoint(const std::array<Eigen::Vector3d, 2>& bearings_in_level,
                         const std::array<Eigen::Vector3d, 2>& x_in_anchor,
                         std::array<LevelPose, 2>* solutions,
                         const std::array<Eigen::Vector3d, 2>& origins_in_level = {
                             Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_SOLVERS_GRAVITY_TWO_POINT_H_
