#include "core/adjust/adjust_costs.h"

#include <Eigen/Geometry>
#include <cmath>

namespace cairn {
namespace {

template <int kRows, int kCols>
using RowMajor =
    Eigen::Matrix<double, kRows, kCols, kCols == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

// The index of the pose's tangent that the index `i` of a tangent without `held` stands for.
int SkipHeld(int i, int held) { return i < held ? i : i + 1; }

}  // namespace

void StorePose(const Rigid3d& cam_from_world, double* pose) {
  Eigen::Map<Eigen::Quaterniond>{pose} = cam_from_world.rotation;
  Eigen::Map<Eigen::Vector3d>{pose + 4} = cam_from_world.Inverse().translation;
}

Rigid3d LoadPose(const double* pose) {
  const Eigen::Quaterniond rotation = Eigen::Map<const Eigen::Quaterniond>(pose).normalized();
  return {rotation, -(rotation * Eigen::Map<const Eigen::Vector3d>(pose + 4))};
}

bool PoseManifold::Plus(const double* pose, const double* delta, double* moved) const {
  const Eigen::Quaterniond rotation = Eigen::Map<const Eigen::Quaterniond>(pose);
  Eigen::Map<Eigen::Quaterniond>{moved} =
      (ExpSo3(Eigen::Map<const Eigen::Vector3d>(delta)) * rotation).normalized();
  Eigen::Map<Eigen::Vector3d>{moved + 4} =
      Eigen::Map<const Eigen::Vector3d>(pose + 4) + Eigen::Map<const Eigen::Vector3d>(delta + 3);
  return true;
}

bool PoseManifold::PlusJacobian(const double*, double* jacobian) const {
  Eigen::Map<RowMajor<kPoseSize, 6>>(jacobian).setIdentity();
  return true;
}

bool PoseManifold::Minus(const double* moved, const double* pose, double* delta) const {
  const Eigen::Quaterniond from = Eigen::Map<const Eigen::Quaterniond>(pose);
  const Eigen::Quaterniond to = Eigen::Map<const Eigen::Quaterniond>(moved);
  Eigen::Map<Eigen::Vector3d>{delta} = LogSo3(to * from.conjugate());
  Eigen::Map<Eigen::Vector3d>{delta + 3} =
      Eigen::Map<const Eigen::Vector3d>(moved + 4) - Eigen::Map<const Eigen::Vector3d>(pose + 4);
  return true;
}

bool PoseManifold::MinusJacobian(const double*, double* jacobian) const {
  Eigen::Map<RowMajor<6, kPoseSize>>(jacobian).setIdentity();
  return true;
}

bool PoseOnPlaneManifold::Plus(const double* pose, const double* delta, double* moved) const {
  double all[6] = {};
  for (int i = 0; i < 5; ++i) {
    all[SkipHeld(i, held_)] = delta[i];
  }
  return PoseManifold().Plus(pose, all, moved);
}

bool PoseOnPlaneManifold::PlusJacobian(const double*, double* jacobian) const {
  Eigen::Map<RowMajor<kPoseSize, 5>> by_delta(jacobian);
  by_delta.setZero();
  for (int i = 0; i < 5; ++i) {
    by_delta(SkipHeld(i, held_), i) = 1.0;
  }
  return true;
}

bool PoseOnPlaneManifold::Minus(const double* moved, const double* pose, double* delta) const {
  double all[6];
  PoseManifold().Minus(moved, pose, all);
  for (int i = 0; i < 5; ++i) {
    delta[i] = all[SkipHeld(i, held_)];
  }
  return true;
}

bool PoseOnPlaneManifold::MinusJacobian(const double*, double* jacobian) const {
  Eigen::Map<RowMajor<5, kPoseSize>> by_moved(jacobian);
  by_moved.setZero();
  for (int i = 0; i < 5; ++i) {
    by_moved(i, SkipHeld(i, held_)) = 1.0;
  }
  return true;
}

bool ReprojectionCost::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> x_in_world(parameters[0]);
  const Eigen::Map<const Eigen::Quaterniond> rotation(parameters[1]);
  const Eigen::Map<const Eigen::Vector3d> center_in_world(parameters[1] + 4);
  const Eigen::Map<const CameraUnknowns> unknowns(parameters[2]);
  const Eigen::Matrix3d cam_from_world = rotation.toRotationMatrix();
  const Eigen::Vector3d x_in_cam = cam_from_world * (x_in_world - center_in_world);

  const bool by_pose = jacobians != nullptr && jacobians[1] != nullptr;
  const bool by_point = jacobians != nullptr && jacobians[0] != nullptr;
  const bool by_camera = jacobians != nullptr && jacobians[2] != nullptr;
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> pixel_by_cam;
  Eigen::Matrix<double, 2, kCameraSize> pixel_by_unknowns;
  if (!camera_->Project(unknowns, x_in_cam, &pixel, by_pose || by_point ? &pixel_by_cam : nullptr,
                        by_camera ? &pixel_by_unknowns : nullptr)) {
    return false;
  }
  Eigen::Map<Eigen::Vector2d>{residuals} = inverse_sigma_ * (pixel - pixel_);
  if (by_point || by_pose) {
    const Eigen::Matrix<double, 2, 3> by_world = inverse_sigma_ * pixel_by_cam * cam_from_world;
    if (by_point) {
      Eigen::Map<RowMajor<2, 3>>{jacobians[0]} = by_world;
    }
    if (by_pose) {
      Eigen::Map<RowMajor<2, kPoseSize>> jacobian(jacobians[1]);
      jacobian.leftCols<3>() = -inverse_sigma_ * pixel_by_cam * Skew(x_in_cam);
      jacobian.middleCols<3>(3) = -by_world;
      jacobian.col(6).setZero();
    }
  }
  if (by_camera) {
    Eigen::Map<RowMajor<2, kCameraSize>>{jacobians[2]} = inverse_sigma_ * pixel_by_unknowns;
  }
  return true;
}

bool PositionCost::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> center(parameters[0] + 4);
  Eigen::Map<Eigen::Vector3d>{residuals} = inverse_sigma_.cwiseProduct(center - center_in_world_);
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<RowMajor<3, kPoseSize>> jacobian(jacobians[0]);
    jacobian.setZero();
    jacobian.middleCols<3>(3) = inverse_sigma_.asDiagonal();
  }
  return true;
}

bool CameraPriorCost::Evaluate(double const* const* parameters, double* residuals,
                               double** jacobians) const {
  const Eigen::Map<const CameraUnknowns> unknowns(parameters[0]);
  Eigen::Map<CameraUnknowns>{residuals} = inverse_sigma_.cwiseProduct(unknowns - start_);
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<RowMajor<kCameraSize, kCameraSize>>{jacobians[0]} = inverse_sigma_.asDiagonal();
  }
  return true;
}

}  // namespace cairn
