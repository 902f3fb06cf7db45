// A kd-tree searched best bin first (Beis and Lowe, "Shape indexing using approximate nearest-
// neighbour search in high-dimensional spaces", CVPR 1997).
#ifndef CAIRN_LAB_RIVALS_INDEX_KD_TREE_H_
#define CAIRN_LAB_RIVALS_INDEX_KD_TREE_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/index/cell_lists.h"
#include "engine/index/matching_index.h"
#include "lab/rivals/index/index_methods.h"

namespace cairn {

// Every node halves its descriptors along the dimension in which they spread most. A query looks
// into the leaves whose bounding boxes are nearest, none of them farther than its distance.
class KdTree : public MatchingIndex {
 public:
  // See MakeMatchingIndex.
  KdTree(const Codebook& codebook, std::span<const uint8_t> codes, const KdTreeOptions& options);

  int64_t Search(const SearchRequest& request, std::vector<DescriptorHit>* hits) const override;
  std::span<const uint32_t> order() const override { return lists_.lists().members; }
  size_t MemoryBytes() const override;

 private:
  struct Tree {
    // Per node: the first of two children that follow one another, or, with the top bit set, the
    // leaf's cell.
    std::vector<uint32_t> links;
    std::vector<uint8_t> lows, highs;  // Bounding boxes, a stride each a node.
    size_t num_leaves = 0;
  };
  struct BuiltTree {
    Tree tree;
    std::vector<uint32_t> cells;  // Of each descriptor.
  };
  static constexpr uint32_t kLeafBit = uint32_t{1} << 31;

  KdTree(const ByteDescriptors& descriptors, const KdTreeOptions& options);
  KdTree(const ByteDescriptors& descriptors, BuiltTree built, const KdTreeOptions& options);
  static BuiltTree Build(const ByteDescriptors& descriptors, const KdTreeOptions& options);
  void AppendVisits(const int16_t* query_steps, uint32_t query_idx, int32_t max_sq_steps,
                    std::vector<CellVisit>* visits) const;
  // Squared distance from a query to the box of a node.
  int32_t SqDistanceToBox(const int16_t* query_steps, uint32_t node) const;

  size_t num_probes_;
  Tree tree_;
  CellLists lists_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_RIVALS_INDEX_KD_TREE_H_
