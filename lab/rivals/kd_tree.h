// A kd-tree searched best bin first (Beis and Lowe, "Shape indexing using approximate
// nearest-neighbor search in high-dimensional spaces", CVPR 1997).
#ifndef CAIRN_LAB_RIVALS_KD_TREE_H_
#define CAIRN_LAB_RIVALS_KD_TREE_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/index/cell_lists.h"
#include "engine/index/matching_index.h"
#include "lab/rivals/index_methods.h"

namespace cairn {

// Every node splits its descriptors in half along the dimension of their largest spread. A query
// searches the leaves with the nearest bounding boxes, and no leaf beyond the query's distance.
class KdTree : public MatchingIndex {
 public:
  // See MakeMatchingIndex.
  KdTree(const Codebook& codebook, std::span<const uint8_t> codes, const KdTreeOptions& options);

  int64_t Search(const SearchRequest& request, std::vector<DescriptorHit>* hits) const override;
  std::span<const uint32_t> order() const override { return lists_.lists().members; }
  size_t MemoryBytes() const override;

 private:
  struct Tree {
    // Per node: the index of the first of two consecutive children. If the top bit is set: the
    // leaf's cell.
    std::vector<uint32_t> links;
    std::vector<uint8_t> lows, highs;  // Bounding boxes; one stride per node.
    size_t num_leaves = 0;
  };
  struct BuiltTree {
    Tree tree;
    std::vector<uint32_t> cells;  // Cell of each descriptor.
  };
  static constexpr uint32_t kLeafBit = uint32_t{1} << 31;

  KdTree(const ByteDescriptors& descriptors, const KdTreeOptions& options);
  KdTree(const ByteDescriptors& descriptors, BuiltTree built, const KdTreeOptions& options);
  static BuiltTree Build(const ByteDescriptors& descriptors, const KdTreeOptions& options);
  void AppendVisits(const int16_t* query_steps, uint32_t query_idx, int32_t max_sq_steps,
                    std::vector<CellVisit>* visits) const;
  // Returns the squared distance from a query to the bounding box of a node.
  int32_t SqDistanceToBox(const int16_t* query_steps, uint32_t node) const;

  size_t num_probes_;
  Tree tree_;
  CellLists lists_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_RIVALS_KD_TREE_H_
