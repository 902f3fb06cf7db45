// Weighted random numbers for samples.
#ifndef CAIRN_ENGINE_POSE_SAMPLING_ALIAS_TABLE_H_
#define CAIRN_ENGINE_POSE_SAMPLING_ALIAS_TABLE_H_

#include <cstdint>
#include <vector>

#include "core/random.h"

namespace cairn {

// Draws numbers in proportion to weights in constant time (Walker 1977; built as Vose 1991).
// Immutable; safe to use from any thread.
class AliasTable {
 public:
  // The weights are finite and not negative; if all are 0, every number is as likely as any other.
  explicit AliasTable(const std::vector<double>& weights);

  int size() const { return static_cast<int>(entries_.size()); }

  // A number in [0, size()), to 2^-32; never one of weight 0, unless all are. size() is positive.
  int Draw(Random* random) const {
    const uint64_t bits = random->Next();
    const auto i = static_cast<uint32_t>(((bits >> 32) * entries_.size()) >> 32);
    return static_cast<uint32_t>(bits) < entries_[i].threshold ? static_cast<int>(i)
                                                               : entries_[i].alias;
  }

 private:
  struct Entry {
    uint32_t threshold = 0;  // The share of a number's draws that stay with it, in 2^-32.
    int32_t alias = 0;       // The number that gets the others.
  };
  std::vector<Entry> entries_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_SAMPLING_ALIAS_TABLE_H_
