// Propagates the state from the newest frame to the newest inertial sample.
#ifndef CAIRN_FUSION_ESTIMATOR_HEAD_H_
#define CAIRN_FUSION_ESTIMATOR_HEAD_H_

#include <Eigen/Core>
#include <cstdint>

#include "core/inertial/imu.h"
#include "core/inertial/imu_buffer.h"
#include "core/inertial/imu_propagation.h"
#include "fusion/filter/filter_state.h"

namespace cairn::fusion {

// The filter's own state moves only at frames; the published one moves with each sample. Does not
// allocate. Not thread-safe.
class Head {
 public:
  Head(const ImuNoise& noise, double gravity_m_s2) : noise_(noise), gravity_m_s2_(gravity_m_s2) {}

  // Starts again at `state`, whose time is `time_ns`.
  void Restart(const FilterState& state, int64_t time_ns);

  // Moves to the newest sample if that is newer than the head. The buffer must cover the time
  // between.
  void CarryOn(const ImuBuffer& imu);

  int64_t time_ns() const { return time_ns_; }
  const ImuState& imu() const { return imu_; }
  // Covariance of [theta, p, v, b_g, b_a].
  const Matrix15d& covariance() const { return covariance_; }
  // Covariance between [theta, p, v, b_g, b_a] and the error of global_from_local.
  const Eigen::Matrix<double, kImuDim, kGlobalDim>& by_global() const { return by_global_; }

 private:
  void Advance(const ImuStep& step);

  ImuNoise noise_;
  double gravity_m_s2_;
  int64_t time_ns_ = 0;
  ImuState imu_;
  FirstEstimate first_;
  Matrix15d covariance_ = Matrix15d::Zero();
  Eigen::Matrix<double, kImuDim, kGlobalDim> by_global_ =
      Eigen::Matrix<double, kImuDim, kGlobalDim>::Zero();
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_ESTIMATOR_HEAD_H_
