#include "eval/recordings/trajectory_interpolation.h"

#include <algorithm>

namespace cairn::fusion {

Rigid3d PoseAt(const std::vector<TruePose>& poses, int64_t timestamp_ns) {
  const auto after = std::lower_bound(
      poses.begin() + 1, poses.end() - 1, timestamp_ns,
      [](const TruePose& pose, int64_t time_ns) { return pose.timestamp_ns < time_ns; });
  const TruePose& a = *(after - 1);
  const TruePose& b = *after;
  const double share = static_cast<double>(timestamp_ns - a.timestamp_ns) /
                       static_cast<double>(b.timestamp_ns - a.timestamp_ns);
  return {a.global_from_imu.rotation.slerp(share, b.global_from_imu.rotation),
          (1.0 - share) * a.global_from_imu.translation + share * b.global_from_imu.translation};
}

Eigen::Vector3d VelocityAt(const std::vector<TruePose>& poses, int64_t timestamp_ns) {
  constexpr int64_t kHalfSpanNs = 20'000'000;
  const int64_t begin_ns = std::max(poses.front().timestamp_ns, timestamp_ns - kHalfSpanNs);
  const int64_t end_ns = std::min(poses.back().timestamp_ns, timestamp_ns + kHalfSpanNs);
  return (PoseAt(poses, end_ns).translation - PoseAt(poses, begin_ns).translation) /
         (1e-9 * static_cast<double>(end_ns - begin_ns));
}

}  // namespace cairn::fusion
