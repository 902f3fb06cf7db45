// How much of what the map knows of a landmark the state still holds: the errors of one landmark do
// not average out.
#ifndef CAIRN_FUSION_MAP_UPDATES_LANDMARK_USES_H_
#define CAIRN_FUSION_MAP_UPDATES_LANDMARK_USES_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace cairn::fusion {

// A landmark's position error is the same in every answer that contains it. Each use takes nine
// tenths of what is left of the landmark's information, so that all uses together say no more than
// the map knows. What has been taken comes back as the state forgets it: a device that stays where
// it is learns nothing new from landmarks it has used, one that drifts may use them again.
// Remembers at least the last kCapacity landmarks. Not thread-safe.
class LandmarkUses {
 public:
  // Factor on the variance of a use now.
  double VarianceFactor(uint64_t landmark_id) const { return 1.0 / Share(Spent(landmark_id)); }

  void Add(uint64_t landmark_id) {
    const double spent = Spent(landmark_id);
    if (recent_.size() >= kCapacity) {
      older_ = std::exchange(recent_, {});
    }
    recent_[landmark_id] = {log_kept_, spent + Share(spent)};
  }

  // The state has lost all but `share_kept`, in [0, 1], of what it knew of where it is in the map.
  void Forget(double share_kept) { log_kept_ += std::log(std::max(share_kept, 1e-12)); }

  void Clear() {
    recent_.clear();
    older_.clear();
  }

 private:
  static constexpr size_t kCapacity = 8192;

  struct Use {
    double log_kept;
    double spent;  // In [0, 1).
  };

  // What a use takes.
  static double Share(double spent) { return 0.9 * std::max(1e-4, 1.0 - spent); }

  double Spent(uint64_t landmark_id) const {
    for (const auto* generation : {&recent_, &older_}) {
      if (const auto found = generation->find(landmark_id); found != generation->end()) {
        return found->second.spent * std::exp(log_kept_ - found->second.log_kept);
      }
    }
    return 0.0;
  }

  double log_kept_ = 0.0;  // Of the product of all shares kept.
  std::unordered_map<uint64_t, Use> recent_;
  std::unordered_map<uint64_t, Use> older_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_MAP_UPDATES_LANDMARK_USES_H_
