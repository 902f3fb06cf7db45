#include "engine/index/cell_lists.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/check.h"

namespace cairn {
namespace {

// Returns the offsets of the cells' lists: num_cells + 1 numbers.
std::vector<uint32_t> CellBegins(std::span<const uint32_t> cells, size_t num_cells,
                                 int num_dropped_bits) {
  std::vector<uint32_t> begin(num_cells + 1, 0);
  for (const uint32_t cell : cells) {
    ++begin[(cell >> num_dropped_bits) + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  return begin;
}

// Sorts the descriptors by cell. A counting sort.
LargeVector<uint32_t> OrderByCell(std::span<const uint32_t> cells, int num_dropped_bits,
                                  std::vector<uint32_t> next) {
  LargeVector<uint32_t> order(cells.size());
  for (size_t descriptor = 0; descriptor < cells.size(); ++descriptor) {
    order[next[cells[descriptor] >> num_dropped_bits]++] = static_cast<uint32_t>(descriptor);
  }
  return order;
}

size_t MaxSize(const TileLists& lists) {
  size_t max_size = 0;
  for (size_t list = 0; list < lists.num_lists(); ++list) {
    max_size = std::max(max_size, lists.Members(list).size());
  }
  return max_size;
}

}  // namespace

TileLists ListsOfCells(std::span<const uint32_t> cells, size_t num_cells, int num_dropped_bits) {
  TileLists lists;
  lists.begin = CellBegins(cells, num_cells, num_dropped_bits);
  lists.members = OrderByCell(cells, num_dropped_bits, lists.begin);
  return lists;
}

CellLists::CellLists(const ByteDescriptors& descriptors, std::span<const uint32_t> cells,
                     size_t num_cells)
    : scale_(descriptors.scale()),
      lists_(ListsOfCells(cells, num_cells)),
      rows_(descriptors.rows(), scale_.stride(), lists_.members),
      max_cell_size_(MaxSize(lists_)) {
  CAIRN_CHECK(lists_.members.size() == descriptors.size(), "every descriptor has a cell");
}

CellLists::CellLists(ByteScale scale, BlockedRows rows, TileLists lists,
                     const CellListsOptions& options)
    : scale_(std::move(scale)),
      lists_(std::move(lists)),
      rows_(std::move(rows)),
      options_(options),
      max_cell_size_(MaxSize(lists_)) {
  CAIRN_CHECK(lists_.members.size() == rows_.size(), "every descriptor has a cell");
}

// Prefetches the cells that come next. Cells lie anywhere in memory, and the lists of many tiles do
// not fit the cache. Reading a cell of a hundred descriptors takes longer than comparing them, so
// the reads of several cells must be under way at once.
class CellLists::Prefetcher {
 public:
  Prefetcher(const CellLists& lists, std::span<const CellVisit> visits)
      : lists_(lists), visits_(visits) {}

  // Call before processing visit i; i increases by 1 each time.
  void Step(size_t i) {
    if (i > 0 && visits_[i].cell != visits_[i - 1].cell) {
      num_ahead_ -= std::min(num_ahead_, NumFetched(visits_[i - 1].cell));
    }
    while (num_ahead_ < kMaxAhead && next_ < visits_.size()) {
      const uint32_t cell = visits_[next_].cell;
      if (next_ == 0 || cell != visits_[next_ - 1].cell) {
        Fetch(cell);
      }
      ++next_;
    }
  }

 private:
  // Rows of 20 bytes in a part of a level 1 cache.
  static constexpr uint32_t kMaxAhead = 512;
  // The processor itself prefetches the rest of a long run.
  static constexpr uint32_t kMaxOfCell = 256;

  // Counts a cell as one block at least, because a block is read as a whole.
  uint32_t NumFetched(uint32_t cell) const {
    return std::clamp<uint32_t>(lists_.End(cell) - lists_.Begin(cell), kBlockRows, kMaxOfCell);
  }
  void Fetch(uint32_t cell) {
    const uint32_t begin = lists_.Begin(cell);
    const uint32_t end = std::min(lists_.End(cell), begin + kMaxOfCell);
    for (uint32_t row = begin / kBlockRows * kBlockRows; row < end; row += kBlockRows) {
      lists_.rows_.Prefetch(row);
      if (!lists_.options_.order.empty()) {
        __builtin_prefetch(&lists_.lists_.members[row]);
      }
    }
    num_ahead_ += NumFetched(cell);
  }

  const CellLists& lists_;
  const std::span<const CellVisit> visits_;
  size_t next_ = 0;         // The first visit whose cell has not been looked at.
  uint32_t num_ahead_ = 0;  // Rows that were prefetched and not compared yet.
};

int64_t CellLists::Search(const BlockQueries& queries, std::span<const CellVisit> visits,
                          HitCollector* collector) const {
  constexpr size_t kVisitsPerQuestion = 64;  // About 0.1 ms.
  std::vector<BlockHit> hits(max_cell_size_ + kRangeSlack);
  Prefetcher prefetcher(*this, visits);
  int64_t num_distances = 0;
  for (size_t i = 0; i < visits.size(); ++i) {
    if (i % kVisitsPerQuestion == 0 && collector->ShouldStop()) {
      break;
    }
    prefetcher.Step(i);
    const auto [cell, query_idx] = visits[i];
    const uint32_t begin = Begin(cell), end = End(cell);
    const size_t num_hits = rows_.Range(queries[query_idx], begin, end,
                                        collector->max_sq_steps(query_idx), hits.data());
    HandOn(query_idx, {hits.data(), num_hits}, collector);
    num_distances += end - begin;
  }
  return num_distances;
}

void CellLists::HandOn(uint32_t query_idx, std::span<BlockHit> hits,
                       HitCollector* collector) const {
  if (options_.order.empty()) {
    collector->Add(query_idx, hits, lists_.members);
    return;
  }
  for (BlockHit& hit : hits) {
    hit.row = lists_.members[hit.row];
  }
  collector->Add(query_idx, hits, options_.order);
}

size_t CellLists::MemoryBytes() const {
  return rows_.MemoryBytes() +
         (lists_.begin.capacity() + lists_.members.capacity()) * sizeof(uint32_t);
}

}  // namespace cairn
