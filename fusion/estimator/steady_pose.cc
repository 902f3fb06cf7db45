#include "fusion/estimator/steady_pose.h"

#include <algorithm>
#include <cmath>

#include "core/angles.h"
#include "core/require.h"

namespace cairn::fusion {

void SteadyPoseOptions::Validate() const {
  RequireOption(time_constant_s >= 0.0 && std::isfinite(time_constant_s),
                "steady.time_constant_s must be finite and not negative");
  RequireOption(max_held_back_m >= 0.0, "steady.max_held_back_m must not be negative");
  RequireOption(max_held_back_rad >= 0.0 && max_held_back_rad < kPi,
                "steady.max_held_back_rad must lie in [0, pi)");
}

double SteadyPose::ShareLeftAfter(int64_t duration_ns) const {
  if (options_.time_constant_s == 0.0) {
    return 0.0;
  }
  const double duration_s = 1e-9 * static_cast<double>(duration_ns);
  return std::exp(-std::max(duration_s, 0.0) / options_.time_constant_s);
}

void SteadyPose::TakeUp(int64_t timestamp_ns, const Rigid3d& before, const Rigid3d& after,
                        int64_t since_ns) {
  const double old_share = ShareLeftAfter(timestamp_ns - taken_up_ns_);
  const double share = ShareLeftAfter(since_ns);
  const Eigen::Quaterniond turn = before.rotation * after.rotation.conjugate();
  turn_ = LogSo3(ExpSo3(old_share * turn_) * ExpSo3(share * LogSo3(turn)));
  shift_ = old_share * shift_ + share * (before.translation - after.translation);
  taken_up_ns_ = timestamp_ns;
  if (!(turn_.norm() <= options_.max_held_back_rad && shift_.norm() <= options_.max_held_back_m)) {
    Reset();
  }
}

Rigid3d SteadyPose::Show(int64_t timestamp_ns, const Rigid3d& pose) const {
  const double share = ShareLeftAfter(timestamp_ns - taken_up_ns_);
  if (share == 0.0) {
    return pose;
  }
  return {ExpSo3(share * turn_) * pose.rotation, pose.translation + share * shift_};
}

void SteadyPose::Reset() {
  turn_.setZero();
  shift_.setZero();
}

}  // namespace cairn::fusion
