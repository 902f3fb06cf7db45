// The variables of the bundle adjustment as Ceres' parameter blocks, and the values that all
// residuals of one evaluation share.
//
// A rotation is R = Exp(theta) R0 with a fixed reference R0 near the solution. Every block is
// therefore a plain vector, and Ceres needs no manifold. A camera's rotation matrix is computed
// once per evaluation instead of once per residual.
#ifndef CAIRN_LAB_RIVALS_FUSION_WINDOW_VARIABLES_H_
#define CAIRN_LAB_RIVALS_FUSION_WINDOW_VARIABLES_H_

#include <ceres/evaluation_callback.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/inertial/imu.h"
#include "core/inertial/preintegration.h"
#include "core/rigid3.h"
#include "fusion/filter/filter_state.h"

namespace cairn::fusion {

inline constexpr int kPoseBlock = 6;      // theta, p.
inline constexpr int kMotionBlock = 9;    // v, b_g, b_a.
inline constexpr int kLandmarkBlock = 3;  // x_in_local.
inline constexpr int kGlobalBlock = 4;    // psi, position of the pivot in global.

// A camera of the window. Its address must not change while a problem refers to it.
struct WindowCamera {
  WindowCamera(const ImuState& state, const Preintegration& since_previous)
      : since_previous(since_previous) {
    SetState(state);
  }

  // Sets the blocks to `state`, with theta = 0.
  void SetState(const ImuState& state);
  ImuState State() const;
  // Moves the reference rotation to the present value.
  void Rebase() { SetState(State()); }
  // Computes the values that follow from the blocks.
  void Prepare(const Rig& rig);
  // Uses the values of the last Prepare.
  Eigen::Vector3d ToCam(const Eigen::Vector3d& x_in_local) const {
    return cam_from_local_rotation * (x_in_local - position_in_local) + imu_in_cam;
  }

  int64_t frame_id = 0;
  int64_t timestamp_ns = 0;
  bool is_keyframe = false;
  Preintegration since_previous;  // From the previous camera; unused in the oldest.
  Matrix15d imu_sqrt_information =
      Matrix15d::Identity();  // Square root information of since_previous.

  std::array<double, kPoseBlock> pose{};
  std::array<double, kMotionBlock> motion{};
  Eigen::Quaterniond reference = Eigen::Quaterniond::Identity();  // R0 of local_from_imu.

  // Set by Prepare.
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // local_from_imu.
  Eigen::Matrix3d theta_jacobian = Eigen::Matrix3d::Identity();  // Left Jacobian at theta.
  Eigen::Matrix3d cam_from_local_rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d position_in_local = Eigen::Vector3d::Zero();  // Position of the IMU.
  Eigen::Vector3d imu_in_cam = Eigen::Vector3d::Zero();         // Origin of the IMU.
};

// global_from_local with four degrees of freedom; gravity is common to both frames. The transform
// turns about the pivot, a point in local. If the pivot is near the cameras, rotation and
// translation are almost uncorrelated.
struct WindowAlignment {
  void Set(const Rigid3d& global_from_local, const Eigen::Vector3d& pivot_in_local);
  Rigid3d GlobalFromLocal() const;
  void Prepare();

  std::array<double, kGlobalBlock> block{};
  Eigen::Quaterniond reference = Eigen::Quaterniond::Identity();
  Eigen::Vector3d pivot_in_local = Eigen::Vector3d::Zero();

  // Set by Prepare.
  Eigen::Matrix3d local_from_global_rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d pivot_in_global = Eigen::Vector3d::Zero();

  Eigen::Vector3d ToLocal(const Eigen::Vector3d& x_in_global) const {
    return local_from_global_rotation * (x_in_global - pivot_in_global) + pivot_in_local;
  }
};

// Prepares the cameras and the alignment before each evaluation.
class PrepareVariables : public ceres::EvaluationCallback {
 public:
  explicit PrepareVariables(const Rig& rig) : rig_(rig) {}

  void Watch(std::vector<WindowCamera*> cameras, WindowAlignment* alignment);
  void Prepare();
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

 private:
  Rig rig_;
  std::vector<WindowCamera*> cameras_;
  WindowAlignment* alignment_ = nullptr;
};

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_WINDOW_VARIABLES_H_
