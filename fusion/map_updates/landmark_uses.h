// Tracks how much of each landmark's information the filter state already holds. The errors of one
// landmark do not average out, so repeated uses of the landmark must count for less.
#ifndef CAIRN_FUSION_MAP_UPDATES_LANDMARK_USES_H_
#define CAIRN_FUSION_MAP_UPDATES_LANDMARK_USES_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace cairn::fusion {

// A landmark's position error is the same in every answer that contains the landmark. Each use
// takes nine tenths of the landmark's remaining information, so that all uses together say no more
// than the map knows.
//
// Information that was taken returns as the state forgets it. A device that stays in place learns
// nothing new from landmarks it has already used; a device that drifts may use them again.
//
// Remembers at least the last kCapacity landmarks. Not thread-safe.
class LandmarkUses {
 public:
  // Factor by which to multiply the landmark's variance if it is used now.
  double VarianceFactor(uint64_t landmark_id) const { return 1.0 / Share(Spent(landmark_id)); }

  void Add(uint64_t landmark_id) {
    const double spent = Spent(landmark_id);
    if (recent_.size() >= kCapacity) {
      older_ = std::exchange(recent_, {});
    }
    recent_[landmark_id] = {log_kept_, spent + Share(spent)};
  }

  // Call when the state has lost part of its knowledge of its place in the map; `share_kept`, in
  // [0, 1], is the part that remains.
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

  // The share of the landmark's information that one use takes.
  static double Share(double spent) { return 0.9 * std::max(1e-4, 1.0 - spent); }

  double Spent(uint64_t landmark_id) const {
    for (const auto* generation : {&recent_, &older_}) {
      if (const auto found = generation->find(landmark_id); found != generation->end()) {
        return found->second.spent * std::exp(log_kept_ - found->second.log_kept);
      }
    }
    return 0.0;
  }

  double log_kept_ = 0.0;  // Log of the product of all shares kept.
  std::unordered_map<uint64_t, Use> recent_;
  std::unordered_map<uint64_t, Use> older_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_MAP_UPDATES_LANDMARK_USES_H_
