#include "fusion/estimator/estimate_at_head.h"

#include "fusion/filter/pose_covariance.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {
namespace {

// Fills in the fields of `global`. The state must be aligned.
void FillGlobal(const FilterState& state, const Head& head, const Rigid3d& shown_from_local,
                const SteadyPose& steady, Estimate* estimate) {
  const Rigid3d& global_from_local = *state.global_from_local();
  const Matrix6d global_covariance =
      state.covariance().block<kGlobalDim, kGlobalDim>(kGlobalIdx, kGlobalIdx);
  estimate->global_from_local = global_from_local * shown_from_local.Inverse();
  // The error moves to the other side of `shown`: by its adjoint.
  const Eigen::Matrix3d turn = shown_from_local.rotation.toRotationMatrix();
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = turn;
  adjoint.bottomLeftCorner<3, 3>() = Skew(shown_from_local.translation) * turn;
  adjoint.bottomRightCorner<3, 3>() = turn;
  const Matrix6d by_global = adjoint * RotationFirst();
  estimate->global_covariance.noalias() = by_global * global_covariance * by_global.transpose();

  estimate->global_from_imu = global_from_local * head.imu().local_from_imu;
  estimate->steady_global_from_imu = steady.Show(head.time_ns(), estimate->global_from_imu);
  Eigen::Matrix<double, 12, 12> joint;
  joint << head.covariance().topLeftCorner<6, 6>(), head.by_global().topRows<6>(),
      head.by_global().topRows<6>().transpose(), global_covariance;
  const Matrix6x12d jacobian = GlobalPoseJacobian(global_from_local, head.imu().local_from_imu);
  estimate->global_from_imu_covariance.noalias() = jacobian * joint * jacobian.transpose();
}

}  // namespace

std::optional<PosesBeforeFrame> FindPosesBeforeFrame(const FilterState& state, const Head& head) {
  const auto& global_from_local = state.global_from_local();
  if (!global_from_local || state.clones().empty()) {
    return std::nullopt;
  }
  const Clone& last = state.clones().back();
  return PosesBeforeFrame{*global_from_local * head.imu().local_from_imu,
                          *global_from_local * last.local_from_imu, last.frame_id,
                          last.timestamp_ns};
}

void TakeUpCorrection(const PosesBeforeFrame& before, const FilterState& state, const Head& head,
                      int64_t frame_ns, SteadyPose* steady) {
  // A device at rest keeps no clone of its last frame, and has not moved since.
  const Rigid3d& global_from_local = *state.global_from_local();
  const int last = FindClone(state, before.last_frame_id);
  const int64_t since_ns = frame_ns - before.last_frame_ns;
  if (last >= 0) {
    const Rigid3d& local_from_imu = state.clones()[static_cast<size_t>(last)].local_from_imu;
    steady->TakeUp(head.time_ns(), before.at_last_frame, global_from_local * local_from_imu,
                   since_ns);
  } else {
    steady->TakeUp(head.time_ns(), before.at_head, global_from_local * head.imu().local_from_imu,
                   since_ns);
  }
}

Estimate EstimateAtHead(const FilterState& state, const Head& head, const LocalSlew& slew,
                        const SteadyPose& steady) {
  const Rigid3d& shown_from_local = slew.shown_from_local();
  const Eigen::Matrix3d turn = shown_from_local.rotation.toRotationMatrix();
  Estimate estimate;
  estimate.timestamp_ns = head.time_ns();
  estimate.imu = head.imu();
  estimate.imu.local_from_imu = shown_from_local * head.imu().local_from_imu;
  estimate.imu.velocity_in_local = turn * head.imu().velocity_in_local;
  Matrix15d by_head = Matrix15d::Identity();
  for (const int offset : {kThetaIdx, kPositionIdx, kVelocityIdx}) {
    by_head.block<3, 3>(offset, offset) = turn;
  }
  estimate.covariance.noalias() = by_head * head.covariance() * by_head.transpose();
  estimate.has_global = state.global_from_local().has_value();
  if (estimate.has_global) {
    FillGlobal(state, head, shown_from_local, steady, &estimate);
  }
  return estimate;
}

}  // namespace cairn::fusion
