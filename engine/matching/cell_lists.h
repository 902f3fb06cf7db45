// Descriptors sorted into the cells of a partition: what inverted lists, inverted multi-index and
// kd-tree have in common.
#ifndef CAIRN_ENGINE_MATCHING_CELL_LISTS_H_
#define CAIRN_ENGINE_MATCHING_CELL_LISTS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/matching/blocked_rows.h"
#include "engine/matching/byte_descriptors.h"
#include "engine/matching/hit_collector.h"
#include "storage/tile_lists.h"

namespace cairn {

// The descriptors of each cell; cells[i] < num_cells is that of descriptor i.
TileLists ListsOfCells(std::span<const uint32_t> cells, size_t num_cells);

// A query looks into a cell.
struct CellVisit {
  uint32_t cell = 0;
  uint32_t query_idx = 0;
};

// The descriptors of a cell lie in a row in memory. Immutable; safe to use from any thread.
class CellLists {
 public:
  // The cell of each descriptor is below num_cells.
  CellLists(const ByteDescriptors& descriptors, std::span<const uint32_t> cells, size_t num_cells);
  // Every descriptor is in one of the lists, which are the cells. `rows` are the descriptors in the
  // order of the lists.
  CellLists(ByteScale scale, BlockedRows rows, TileLists lists);

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

  ByteScale scale_;
  TileLists lists_;  // The members are the descriptors of the rows.
  BlockedRows rows_;
  size_t max_cell_size_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_CELL_LISTS_H_
