// Descriptors of simulated landmarks without a city around them; private to experiments.
#ifndef CAIRN_LAB_EXPERIMENTS_RUNS_DESCRIPTOR_LOOKS_H_
#define CAIRN_LAB_EXPERIMENTS_RUNS_DESCRIPTOR_LOOKS_H_

#include <cstdint>

#include "core/features.h"
#include "ingest/quantize/train_codebook.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// Looks at landmarks with the numbers from `first` on. A third of the landmarks are one of five
// that share an ornament.
class DescriptorLooks {
 public:
  explicit DescriptorLooks(uint64_t seed) : seed_(seed) {}

  // Row i is a look at landmark first + i / looks_each: by a car, or by a phone, which looks from
  // elsewhere in another light. 128-D, raw.
  DescriptorMatrix ByCar(uint64_t first, int num_landmarks, int looks_each) const;
  DescriptorMatrix ByPhone(uint64_t first, int num_landmarks) const;

  // A codebook trained as ingest does it, on landmarks of which the other methods never tell.
  Codebook Train(const CodebookOptions& options) const;

 private:
  uint64_t seed_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_RUNS_DESCRIPTOR_LOOKS_H_
