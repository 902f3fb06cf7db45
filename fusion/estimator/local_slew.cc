#include "fusion/estimator/local_slew.h"

#include <algorithm>

#include "core/rotation_between.h"

namespace cairn::fusion {
namespace {

Eigen::Quaterniond Yaw(double yaw_rad) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
}

}  // namespace

void LocalSlew::TakeUp(const Rigid3d& before, const Rigid3d& after) {
  const Eigen::Quaterniond turn = Yaw(YawRad(before.rotation * after.rotation.conjugate()));
  shown_from_local_ =
      shown_from_local_ * Rigid3d(turn, before.translation - turn * after.translation);
}

void LocalSlew::Return(const Rigid3d& local_from_imu) {
  const Eigen::Vector3d& position = local_from_imu.translation;
  const double yaw_rad = YawRad(shown_from_local_.rotation);
  const Eigen::Vector3d offset = shown_from_local_ * position - position;
  const Eigen::Quaterniond new_yaw =
      Yaw(yaw_rad - std::clamp(yaw_rad, -max_rad_per_frame_, max_rad_per_frame_));
  const double distance_m = offset.norm();
  const Eigen::Vector3d new_offset =
      distance_m <= max_m_per_frame_
          ? Eigen::Vector3d::Zero().eval()
          : Eigen::Vector3d(offset * (1.0 - max_m_per_frame_ / distance_m));
  shown_from_local_ = Rigid3d(new_yaw, position + new_offset - new_yaw * position);
}

}  // namespace cairn::fusion
