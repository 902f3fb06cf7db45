#include "lab/rivals/fusion/window_variables.h"

#include <utility>

#include "core/inertial/so3_jacobians.h"

namespace cairn::fusion {
namespace {

using ConstMap3d = Eigen::Map<const Eigen::Vector3d>;
using Map3d = Eigen::Map<Eigen::Vector3d>;

Eigen::Quaterniond AboutVertical(double angle_rad) { return ExpSo3({0.0, 0.0, angle_rad}); }

}  // namespace

void WindowCamera::SetState(const ImuState& state) {
  reference = state.local_from_imu.rotation;
  Map3d(pose.data()).setZero();
  Map3d(pose.data() + 3) = state.local_from_imu.translation;
  Map3d(motion.data()) = state.velocity_in_local;
  Map3d(motion.data() + 3) = state.gyro_bias;
  Map3d(motion.data() + 6) = state.accel_bias;
}

ImuState WindowCamera::State() const {
  ImuState state;
  state.local_from_imu = Rigid3d(ExpSo3(ConstMap3d(pose.data())) * reference,
                                 Eigen::Vector3d(ConstMap3d(pose.data() + 3)));
  state.velocity_in_local = ConstMap3d(motion.data());
  state.gyro_bias = ConstMap3d(motion.data() + 3);
  state.accel_bias = ConstMap3d(motion.data() + 6);
  return state;
}

void WindowCamera::Prepare(const Rig& rig) {
  const Eigen::Vector3d theta = ConstMap3d(pose.data());
  rotation = ExpSo3(theta) * reference;
  theta_jacobian = LeftJacobian(theta);
  cam_from_local_rotation = (rig.cam_from_imu.rotation * rotation.conjugate()).toRotationMatrix();
  position_in_local = ConstMap3d(pose.data() + 3);
  imu_in_cam = rig.cam_from_imu.translation;
}

void WindowAlignment::Set(const Rigid3d& global_from_local, const Eigen::Vector3d& pivot) {
  reference = global_from_local.rotation;
  pivot_in_local = pivot;
  block[0] = 0.0;
  Map3d(block.data() + 1) = global_from_local * pivot;
}

Rigid3d WindowAlignment::GlobalFromLocal() const {
  const Eigen::Quaterniond rotation = AboutVertical(block[0]) * reference;
  return {rotation, ConstMap3d(block.data() + 1) - rotation * pivot_in_local};
}

void WindowAlignment::Prepare() {
  local_from_global_rotation = (AboutVertical(block[0]) * reference).conjugate().toRotationMatrix();
  pivot_in_global = ConstMap3d(block.data() + 1);
}

void PrepareVariables::Watch(std::vector<WindowCamera*> cameras, WindowAlignment* alignment) {
  cameras_ = std::move(cameras);
  alignment_ = alignment;
}

void PrepareVariables::Prepare() {
  for (WindowCamera* camera : cameras_) {
    camera->Prepare(rig_);
  }
  if (alignment_ != nullptr) {
    alignment_->Prepare();
  }
}

void PrepareVariables::PrepareForEvaluation(bool /*evaluate_jacobians*/,
                                            bool new_evaluation_point) {
  if (new_evaluation_point) {
    Prepare();
  }
}

}  // namespace cairn::fusion
