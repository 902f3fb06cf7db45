// Descriptors sorted into the cells of a partition: what inverted lists, inverted multi-index and
// kd-tree have in common.
#ifndef CAIRN_ENGINE_INDEX_CELL_LISTS_H_
#define CAIRN_ENGINE_INDEX_CELL_LISTS_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "engine/index/kernels/blocked_rows.h"
#include "engine/index/kernels/byte_descriptors.h"
#include "engine/index/kernels/hit_collector.h"
#include "storage/tile/tile_lists.h"

namespace cairn {

// The descriptors of each cell; cells[i] < num_cells is that of descriptor i.
TileLists ListsOfCells(std::span<const uint32_t> cells, size_t num_cells);

// A query looks into a cell.
struct CellVisit {
  uint32_t cell = 0;
  uint32_t query_idx = 0;
};

struct CellListsOptions {
  // Of a cell only the first so many members are compared with a query.
  uint32_t max_compared = std::numeric_limits<uint32_t>::max();
  // If there is one, members are places in it, and hits are given by them. Must outlive the lists.
  std::span<const uint32_t> order = {};
};

// The descriptors of a cell lie in a row in memory. Immutable; safe to use from any thread.
class CellLists {
 public:
  // The cell of each descriptor is below num_cells.
  CellLists(const ByteDescriptors& descriptors, std::span<const uint32_t> cells, size_t num_cells);
  // Every descriptor is in one of the lists, which are the cells. `rows` are the descriptors in the
  // order of the lists.
  CellLists(ByteScale scale, BlockedRows rows, TileLists lists,
            const CellListsOptions& options = {});

  const ByteScale& scale() const { return scale_; }
  const BlockedRows& rows() const { return rows_; }
  const TileLists& lists() const { return lists_; }
  size_t size() const { return lists_.members.size(); }
  size_t num_cells() const { return lists_.num_lists(); }

  // Queries, as ByteScale makes them, in the form that Search takes.
  BlockQueries Prepare(std::span<const int16_t> query_steps) const {
    return BlockQueries(query_steps, rows_.centers());
  }

  // Compares queries with the descriptors of the cells they visit, in the order of the visits,
  // until the collector wants no more.
  // Returns the number of distances computed.
  int64_t Search(const BlockQueries& queries, std::span<const CellVisit> visits,
                 HitCollector* collector) const;

  size_t MemoryBytes() const;

 private:
  class Prefetcher;

  // Rows of a cell that are compared.
  uint32_t Begin(uint32_t cell) const { return lists_.begin[cell]; }
  uint32_t End(uint32_t cell) const {
    const uint32_t begin = lists_.begin[cell];
    return begin + std::min(lists_.begin[cell + 1] - begin, options_.max_compared);
  }
  void HandOn(uint32_t query_idx, std::span<BlockHit> hits, HitCollector* collector) const;

  ByteScale scale_;
  TileLists lists_;  // The members are the descriptors of the rows.
  BlockedRows rows_;
  CellListsOptions options_;
  size_t max_cell_size_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_CELL_LISTS_H_
