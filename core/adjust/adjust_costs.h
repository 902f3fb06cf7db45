// The residuals of the adjustment, with analytic Jacobians, and the manifold of poses. Private to
// core/adjust; docs/math/mapping_adjustment.md derives them.
#ifndef CAIRN_CORE_ADJUST_ADJUST_COSTS_H_
#define CAIRN_CORE_ADJUST_ADJUST_COSTS_H_

#include <ceres/manifold.h>
#include <ceres/sized_cost_function.h>

#include <Eigen/Core>

#include "core/adjust/adjustable_camera.h"
#include "core/rigid3.h"

namespace cairn {

// A pose as Ceres sees it: the quaternion (x, y, z, w) of cam_from_world, and the center of the
// camera in the world.
inline constexpr int kPoseSize = 7;
inline constexpr int kPointSize = 3;

void StorePose(const Rigid3d& cam_from_world, double* pose);
Rigid3d LoadPose(const double* pose);

// Changes a pose by six numbers: R becomes Exp(first three) R, the center moves by the last three.
//
// The costs below write Jacobians with respect to these six numbers, with a seventh column of
// zeros. PlusJacobian is therefore the identity above a row of zeros, and no cost passes through
// the derivatives of a quaternion.
class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseSize; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* pose, const double* delta, double* moved) const override;
  bool PlusJacobian(const double* pose, double* jacobian) const override;
  bool Minus(const double* moved, const double* pose, double* delta) const override;
  bool MinusJacobian(const double* pose, double* jacobian) const override;
};

// The same with one coordinate of the center held, which fixes the scale.
class PoseOnPlaneManifold : public ceres::Manifold {
 public:
  explicit PoseOnPlaneManifold(int held_axis) : held_(3 + held_axis) {}
  int AmbientSize() const override { return kPoseSize; }
  int TangentSize() const override { return 5; }
  bool Plus(const double* pose, const double* delta, double* moved) const override;
  bool PlusJacobian(const double* pose, double* jacobian) const override;
  bool Minus(const double* moved, const double* pose, double* delta) const override;
  bool MinusJacobian(const double* pose, double* jacobian) const override;

 private:
  int held_;
};

// (projection - keypoint) / sigma, of a point, a pose and the unknowns of a camera.
class ReprojectionCost : public ceres::SizedCostFunction<2, kPointSize, kPoseSize, kCameraSize> {
 public:
  // Does not own `camera`.
  ReprojectionCost(const AdjustableCamera* camera, const Eigen::Vector2d& pixel, double sigma_px)
      : camera_(camera), pixel_(pixel), inverse_sigma_(1.0 / sigma_px) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const AdjustableCamera* camera_;
  Eigen::Vector2d pixel_;
  double inverse_sigma_;
};

// (center - known center) / sigma, of a pose.
class PositionCost : public ceres::SizedCostFunction<3, kPoseSize> {
 public:
  PositionCost(const Eigen::Vector3d& center_in_world, const Eigen::Vector3d& sigma)
      : center_in_world_(center_in_world), inverse_sigma_(sigma.cwiseInverse()) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector3d center_in_world_;
  Eigen::Vector3d inverse_sigma_;
};

// (unknowns - start) / sigma, of the unknowns of a camera; an infinite sigma asks for nothing.
class CameraPriorCost : public ceres::SizedCostFunction<kCameraSize, kCameraSize> {
 public:
  CameraPriorCost(const CameraUnknowns& start, const CameraUnknowns& sigma)
      : start_(start), inverse_sigma_(sigma.cwiseInverse()) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  CameraUnknowns start_;
  CameraUnknowns inverse_sigma_;
};

}  // namespace cairn

#endif  // CAIRN_CORE_ADJUST_ADJUST_COSTS_H_
