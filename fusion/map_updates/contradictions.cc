#include "fusion/map_updates/contradictions.h"

#include <algorithm>

#include "core/inertial/imu_time.h"
#include "fusion/map_updates/alignment.h"

namespace cairn::fusion {
namespace {

constexpr size_t kMaxContradictions = 16;

}  // namespace

bool Contradictions::Add(int64_t timestamp_ns, const Rigid3d& global_from_local,
                         const Eigen::Vector3d& x_in_local) {
  contradictions_.push_back({timestamp_ns, global_from_local});
  if (contradictions_.size() > kMaxContradictions) {
    contradictions_.erase(contradictions_.begin());
  }
  const auto differs = [&](const Contradiction& contradiction) {
    return !Agree(contradiction.global_from_local, global_from_local, x_in_local);
  };
  const auto last_differing =
      std::find_if(contradictions_.rbegin(), contradictions_.rend(), differs);
  contradictions_.erase(contradictions_.begin(), last_differing.base());
  const auto [oldest, newest] =
      std::minmax_element(contradictions_.begin(), contradictions_.end(),
                          [](const Contradiction& a, const Contradiction& b) {
                            return a.timestamp_ns < b.timestamp_ns;
                          });
  if (static_cast<int>(contradictions_.size()) < kMinContradictions ||
      ToSeconds(newest->timestamp_ns - oldest->timestamp_ns) < kMinContradictionSpanS) {
    return false;
  }
  contradictions_.clear();
  return true;
}

}  // namespace cairn::fusion
