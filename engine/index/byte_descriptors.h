// Descriptors as bytes, in the order of the tile.
#ifndef CAIRN_ENGINE_INDEX_BYTE_DESCRIPTORS_H_
#define CAIRN_ENGINE_INDEX_BYTE_DESCRIPTORS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/features.h"
#include "engine/index/byte_scale.h"
#include "engine/index/hit_collector.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// Immutable; safe to use from any thread.
class ByteDescriptors {
 public:
  // codes: n x codebook.num_subspaces bytes.
  ByteDescriptors(const Codebook& codebook, std::span<const uint8_t> codes);

  const ByteScale& scale() const { return scale_; }
  const uint8_t* rows() const { return rows_.data(); }  // size() x scale().stride().
  size_t size() const { return num_rows_; }
  size_t MemoryBytes() const { return rows_.capacity(); }

  // Finds all hits by comparing every query with every descriptor; see MatchingIndex::Search. Hits
  // are ordered by query, then descriptor.
  int64_t Search(const SearchRequest& request, std::vector<DescriptorHit>* hits) const;

  // Finds all descriptors within `max_distance` of each query (n x dim, projected space). Appends
  // to `hits`, ordered by query, then descriptor. Throws Error(kInternal) if the dimensions differ.
  void RangeSearch(const DescriptorMatrix& queries, double max_distance,
                   std::vector<DescriptorHit>* hits) const;

 private:
  ByteScale scale_;
  size_t num_rows_ = 0;
  std::vector<uint8_t> rows_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_BYTE_DESCRIPTORS_H_
