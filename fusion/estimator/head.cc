#include "fusion/estimator/head.h"

namespace cairn::fusion {

void Head::Restart(const FilterState& state, int64_t time_ns) {
  time_ns_ = time_ns;
  imu_ = state.imu();
  first_ = {imu_.local_from_imu.translation, imu_.velocity_in_local};
  covariance_ = state.covariance().topLeftCorner<kImuDim, kImuDim>();
  by_global_ = state.covariance().block<kImuDim, kGlobalDim>(0, kGlobalIdx);
}

void Head::CarryOn(const ImuBuffer& imu) {
  if (imu.size() > 1 && imu.newest_ns() > time_ns_) {
    imu.ForEachStep(time_ns_, imu.newest_ns(), [this](const ImuStep& step) { Advance(step); });
    time_ns_ = imu.newest_ns();
  }
}

void Head::Advance(const ImuStep& step) {
  ImuTransition transition;
  Propagate(step, noise_, gravity_m_s2_, &imu_, &first_, &transition);
  const Matrix15d moved = transition.phi * covariance_;
  covariance_.noalias() = moved * transition.phi.transpose();
  covariance_ += transition.noise;
  by_global_ = (transition.phi * by_global_).eval();
}

}  // namespace cairn::fusion
