// How often landmarks have been used: the errors of one landmark do not average out.
#ifndef CAIRN_FUSION_LANDMARK_USES_H_
#define CAIRN_FUSION_LANDMARK_USES_H_

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace cairn::fusion {

// A landmark's position error is the same in every answer that contains it. The n-th use of a
// landmark gets n (n + 1) times its variance: as the reciprocals sum to one, however often it is
// used, all uses together say no more about the landmark than the map knows. Remembers at least the
// last kCapacity landmarks. Not thread-safe.
class LandmarkUses {
 public:
  // Factor on the variance of the next use.
  double VarianceFactor(uint64_t landmark_id) const {
    const double n = Count(landmark_id) + 1.0;
    return n * (n + 1.0);
  }

  void Add(uint64_t landmark_id) {
    const int count = Count(landmark_id) + 1;
    if (recent_.size() >= kCapacity) {
      older_ = std::exchange(recent_, {});
    }
    recent_[landmark_id] = count;
  }

  void Clear() {
    recent_.clear();
    older_.clear();
  }

 private:
  static constexpr size_t kCapacity = 8192;

  int Count(uint64_t landmark_id) const {
    for (const auto* generation : {&recent_, &older_}) {
      if (const auto found = generation->find(landmark_id); found != generation->end()) {
        return found->second;
      }
    }
    return 0;
  }

  std::unordered_map<uint64_t, int> recent_;
  std::unordered_map<uint64_t, int> older_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_LANDMARK_USES_H_
