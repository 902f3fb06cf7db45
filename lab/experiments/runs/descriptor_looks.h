// Descriptors of simulated landmarks without a city. Private to experiments.
#ifndef CAIRN_LAB_EXPERIMENTS_RUNS_DESCRIPTOR_LOOKS_H_
#define CAIRN_LAB_EXPERIMENTS_RUNS_DESCRIPTOR_LOOKS_H_

#include <cstdint>

#include "core/features.h"
#include "ingest/codebook/train_codebook.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// Looks at landmarks, which are numbered from `first` on. A third of the landmarks belong to groups
// of five that share an ornament.
class DescriptorLooks {
 public:
  explicit DescriptorLooks(uint64_t seed) : seed_(seed) {}

  // Row i is a look at landmark first + i / looks_each (ByPhone: one look each). ByCar gives a
  // car's looks. ByPhone gives a phone's looks, from other directions and in other light. 128-D,
  // raw.
  DescriptorMatrix ByCar(uint64_t first, int num_landmarks, int looks_each) const;
  DescriptorMatrix ByPhone(uint64_t first, int num_landmarks) const;

  // Returns a codebook trained as ingest does, on landmarks that the other methods never return.
  Codebook Train(const CodebookOptions& options) const;

 private:
  uint64_t seed_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_RUNS_DESCRIPTOR_LOOKS_H_
