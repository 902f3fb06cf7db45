// Weighted random numbers for sampling.
#ifndef CAIRN_ENGINE_POSE_ALIAS_TABLE_H_
#define CAIRN_ENGINE_POSE_ALIAS_TABLE_H_

#include <cstdint>
#include <vector>

#include "core/random.h"

namespace cairn {

// Draws numbers with probabilities proportional to weights, in constant time (Walker 1977; built as
// in Vose 1991). Immutable; safe to use from any thread.
class AliasTable {
 public:
  // The weights must be finite and not negative. If all are 0, every number is equally likely.
  explicit AliasTable(const std::vector<double>& weights);

  int size() const { return static_cast<int>(entries_.size()); }

  // Returns a number in [0, size()); probabilities are accurate to 2^-32. Never returns a number of
  // weight 0 unless all weights are 0. size() must be positive.
  int Draw(Random* random) const {
    const uint64_t bits = random->Next();
    const auto i = static_cast<uint32_t>(((bits >> 32) * entries_.size()) >> 32);
    return static_cast<uint32_t>(bits) < entries_[i].threshold ? static_cast<int>(i)
                                                               : entries_[i].alias;
  }

 private:
  struct Entry {
    uint32_t threshold = 0;  // Share of draws that keep the number, in units of 2^-32.
    int32_t alias = 0;       // The number that the other draws return.
  };
  std::vector<Entry> entries_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_ALIAS_TABLE_H_
