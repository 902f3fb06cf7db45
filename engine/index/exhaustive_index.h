// The baseline without an index: compares every query with every descriptor.
#ifndef CAIRN_ENGINE_INDEX_EXHAUSTIVE_INDEX_H_
#define CAIRN_ENGINE_INDEX_EXHAUSTIVE_INDEX_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/index/byte_descriptors.h"
#include "engine/index/matching_index.h"

namespace cairn {

class ExhaustiveIndex : public MatchingIndex {
 public:
  // See MakeMatchingIndex.
  ExhaustiveIndex(const Codebook& codebook, std::span<const uint8_t> codes)
      : descriptors_(codebook, codes) {}

  int64_t Search(const SearchRequest& request, std::vector<DescriptorHit>* hits) const override {
    return descriptors_.Search(request, hits);
  }
  size_t MemoryBytes() const override { return descriptors_.MemoryBytes(); }

 private:
  ByteDescriptors descriptors_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_EXHAUSTIVE_INDEX_H_
