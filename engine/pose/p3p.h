// Minimal problem: camera pose from three 2D-3D points (P3P), after Persson and Nordberg, "Lambda
// Twist: An Accurate Fast Robust Perspective Three Point (P3P) Solver", ECCV 2018.
#ifndef CAIRN_ENGINE_POSE_P3P_H_
#define CAIRN_ENGINE_POSE_P3P_H_

#include <Eigen/Core>
#include <array>

namespace cairn {

// Finds the poses cam_from_anchor = [R | t] from which the landmarks `x_in_anchor` are seen along
// the unit vectors `bearings_in_cam`, all at positive depth. Returns the number of poses, 0 to 4,
// and writes them to `solutions`; R is a rotation up to rounding. Returns 0 if the landmarks are
// collinear (or two coincide) or two bearings are equal.
//
// The depths lie on two conics of the pencil that the three distance equations span. As in the
// paper, a degenerate member of the pencil splits into two lines. This implementation intersects
// each line with another member in homogeneous coordinates, so that it never divides by a
// particular depth.
int SolveP3p(const std::array<Eigen::Vector3d, 3>& bearings_in_cam,
             const std::array<Eigen::Vector3d, 3>& x_in_anchor,
             std::array<Eigen::Matrix<double, 3, 4>, 4>* solutions);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_P3P_H_
