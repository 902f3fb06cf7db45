// The part of Estimator that carries the newest frame's state on to the newest inertial sample.
#include "fusion/client/estimator.h"
#include "fusion/client/pose_covariance.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {

void Estimator::RestartHead() {
  head_ = state_->imu();
  head_first_ = {head_.local_from_imu.translation, head_.velocity_in_local};
  head_covariance_ = state_->covariance().topLeftCorner<kImuDim, kImuDim>();
  head_by_global_ = state_->covariance().block<kImuDim, kGlobalDim>(0, kGlobalIdx);
  head_time_ns_ = filter_time_ns_;
  if (imu_.size() > 1 && imu_.newest_ns() > head_time_ns_) {
    imu_.ForEachStep(head_time_ns_, imu_.newest_ns(),
                     [this](const ImuStep& step) { AdvanceHead(step); });
    head_time_ns_ = imu_.newest_ns();
  }
}

void Estimator::AdvanceHead(const ImuStep& step) {
  ImuTransition transition;
  Propagate(step, options_.imu_noise, options_.gravity_m_s2, &head_, &head_first_, &transition);
  const Matrix15d moved = transition.phi * head_covariance_;
  head_covariance_.noalias() = moved * transition.phi.transpose();
  head_covariance_ += transition.noise;
  head_by_global_ = (transition.phi * head_by_global_).eval();
}

std::optional<Rigid3d> Estimator::GlobalFromHead() const {
  const auto& global = state_->global_from_local();
  return global ? std::optional(*global * head_.local_from_imu) : std::nullopt;
}

std::optional<Estimator::Uncorrected> Estimator::BeforeFrame() const {
  const auto& global = state_->global_from_local();
  if (!global || state_->clones().empty()) {
    return std::nullopt;
  }
  const Clone& last = state_->clones().back();
  return Uncorrected{*GlobalFromHead(), *global * last.local_from_imu, last.frame_id,
                     last.timestamp_ns, counters_.num_alignments};
}

void Estimator::SteadyHead(const std::optional<Uncorrected>& before) {
  const std::optional<Rigid3d> after = GlobalFromHead();
  if (!before || !after || counters_.num_alignments != before->num_alignments) {
    steady_.Reset();
    return;
  }
  // A device at rest keeps no clone of its last frame, and has not moved since.
  const int last = FindClone(*state_, before->last_frame_id);
  const int64_t since_ns = filter_time_ns_ - before->last_frame_ns;
  if (last >= 0) {
    const Rigid3d& local_from_imu = state_->clones()[static_cast<size_t>(last)].local_from_imu;
    steady_.TakeUp(head_time_ns_, before->at_last_frame,
                   *state_->global_from_local() * local_from_imu, since_ns);
  } else {
    steady_.TakeUp(head_time_ns_, before->at_head, *after, since_ns);
  }
}

void Estimator::PublishHead() {
  latest_.epoch = epoch_;
  if (!state_) {
    latest_.mode = resting_mode_;
    latest_.has_global = false;
    return;
  }
  const auto& global = state_->global_from_local();
  latest_.has_global = global.has_value();
  if (!global) {
    latest_.mode = candidates_.empty() ? Mode::kTracking : Mode::kAligning;
  } else {
    const double since_s = 1e-9 * static_cast<double>(head_time_ns_ - *last_applied_ns_);
    latest_.mode = since_s < options_.coasting_after_s ? Mode::kLocalized : Mode::kCoasting;
  }
  latest_.timestamp_ns = head_time_ns_;
  const Rigid3d& shown = slew_.shown_from_local();
  const Eigen::Matrix3d turn = shown.rotation.toRotationMatrix();
  latest_.imu = head_;
  latest_.imu.local_from_imu = shown * head_.local_from_imu;
  latest_.imu.velocity_in_local = turn * head_.velocity_in_local;
  Matrix15d by_head = Matrix15d::Identity();
  for (const int offset : {kThetaIdx, kPositionIdx, kVelocityIdx}) {
    by_head.block<3, 3>(offset, offset) = turn;
  }
  latest_.covariance.noalias() = by_head * head_covariance_ * by_head.transpose();
  if (!global) {
    return;
  }
  const Matrix6d global_covariance =
      state_->covariance().block<kGlobalDim, kGlobalDim>(kGlobalIdx, kGlobalIdx);
  latest_.global_from_local = *global * shown.Inverse();
  // The error moves to the other side of `shown`: by its adjoint.
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = turn;
  adjoint.bottomLeftCorner<3, 3>() = Skew(shown.translation) * turn;
  adjoint.bottomRightCorner<3, 3>() = turn;
  const Matrix6d by_global = adjoint * RotationFirst();
  latest_.global_covariance.noalias() = by_global * global_covariance * by_global.transpose();
  latest_.global_from_imu = *GlobalFromHead();
  latest_.steady_global_from_imu = steady_.Show(head_time_ns_, latest_.global_from_imu);
  Eigen::Matrix<double, 12, 12> joint;
  joint << head_covariance_.topLeftCorner<6, 6>(), head_by_global_.topRows<6>(),
      head_by_global_.topRows<6>().transpose(), global_covariance;
  const Matrix6x12d jacobian = GlobalPoseJacobian(*global, head_.local_from_imu);
  latest_.global_from_imu_covariance.noalias() = jacobian * joint * jacobian.transpose();
}

}  // namespace cairn::fusion
