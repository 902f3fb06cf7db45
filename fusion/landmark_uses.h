// How much of what the map knows of a landmark has been used: the errors of one landmark do not
// average out.
#ifndef CAIRN_FUSION_LANDMARK_USES_H_
#define CAIRN_FUSION_LANDMARK_USES_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace cairn::fusion {

// A landmark's position error is the same in every answer that contains it. Each use takes nine
// tenths of what is left of the landmark's information, so that all uses together say no more than
// the map knows. What has been taken comes back with time: the drift of the pose covers the old
// use, and a device that stays in one place must not grow deaf to the map. Remembers at least the
// last kCapacity landmarks. Not thread-safe.
class LandmarkUses {
 public:
  // Factor on the variance of a use at an instant.
  double VarianceFactor(uint64_t landmark_id, int64_t timestamp_ns) const {
    return 1.0 / Share(Spent(landmark_id, timestamp_ns));
  }

  void Add(uint64_t landmark_id, int64_t timestamp_ns) {
    const double spent = Spent(landmark_id, timestamp_ns);
    if (recent_.size() >= kCapacity) {
      older_ = std::exchange(recent_, {});
    }
    recent_[landmark_id] = {timestamp_ns, spent + Share(spent)};
  }

  void Clear() {
    recent_.clear();
    older_.clear();
  }

 private:
  static constexpr size_t kCapacity = 8192;
  static constexpr double kReturnTimeS = 20.0;  // In which all but 1 / e comes back.

  struct Use {
    int64_t timestamp_ns;
    double spent;  // In [0, 1).
  };

  // What a use takes.
  static double Share(double spent) { return 0.9 * std::max(1e-4, 1.0 - spent); }

  double Spent(uint64_t landmark_id, int64_t timestamp_ns) const {
    for (const auto* generation : {&recent_, &older_}) {
      if (const auto found = generation->find(landmark_id); found != generation->end()) {
        const double since_s =
            1e-9 * static_cast<double>(timestamp_ns - found->second.timestamp_ns);
        return found->second.spent * std::exp(-std::abs(since_s) / kReturnTimeS);
      }
    }
    return 0.0;
  }

  std::unordered_map<uint64_t, Use> recent_;
  std::unordered_map<uint64_t, Use> older_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_LANDMARK_USES_H_
