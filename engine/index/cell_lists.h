// Descriptors sorted by the cells of a partition. Shared by inverted lists, random grids, the
// inverted multi-index and the kd-tree.
//
// The terms of engine/index: a cell is a region of descriptor space; a list holds the descriptors
// of a cell; a word is the centroid of a cell; a bucket is the list of all cells whose hashes share
// the upper bits.
#ifndef CAIRN_ENGINE_INDEX_CELL_LISTS_H_
#define CAIRN_ENGINE_INDEX_CELL_LISTS_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "engine/index/blocked_rows.h"
#include "engine/index/byte_descriptors.h"
#include "engine/index/hit_collector.h"
#include "storage/tile/tile_lists.h"

namespace cairn {

// Returns the list of each cell. cells[i] >> num_dropped_bits, which is below num_cells, is the
// cell of descriptor i.
TileLists ListsOfCells(std::span<const uint32_t> cells, size_t num_cells, int num_dropped_bits = 0);

// A query visits a cell: it is compared with the cell's descriptors.
struct CellVisit {
  uint32_t cell = 0;
  uint32_t query_idx = 0;
};

struct CellListsOptions {
  // A query is compared with only this many members of a cell, the first ones.
  uint32_t max_compared = std::numeric_limits<uint32_t>::max();
  // If not empty, the lists' members are indices into `order`, and hits report these indices.
  // `order` must outlive the lists.
  std::span<const uint32_t> order = {};
};

// The descriptors of each cell are contiguous in memory. Immutable; safe to use from any thread.
class CellLists {
 public:
  // The cell of each descriptor must be below num_cells.
  CellLists(const ByteDescriptors& descriptors, std::span<const uint32_t> cells, size_t num_cells);
  // Each list is a cell; every descriptor is in one list. `rows` holds the descriptors in list
  // order.
  CellLists(ByteScale scale, BlockedRows rows, TileLists lists,
            const CellListsOptions& options = {});

  const ByteScale& scale() const { return scale_; }
  const BlockedRows& rows() const { return rows_; }
  const TileLists& lists() const { return lists_; }
  size_t size() const { return lists_.members.size(); }
  size_t num_cells() const { return lists_.num_lists(); }

  // Converts queries from ByteScale to the form that Search takes.
  BlockQueries Prepare(std::span<const int16_t> query_steps) const {
    return BlockQueries(query_steps, rows_.centers());
  }

  // Compares queries with the descriptors of the cells they visit, in the order of the visits,
  // until the collector asks to stop. Returns the number of distances computed.
  int64_t Search(const BlockQueries& queries, std::span<const CellVisit> visits,
                 HitCollector* collector) const;

  size_t MemoryBytes() const;

 private:
  class Prefetcher;

  // Return the range of a cell's rows that are compared.
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
