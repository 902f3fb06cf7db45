#include "engine/matching/cell_lists.h"

#include <algorithm>
#include <numeric>

#include "core/check.h"

namespace cairn {
namespace {

// Offsets of the cells, one more than there are.
std::vector<uint32_t> CellBegins(std::span<const uint32_t> cells, size_t num_cells) {
  std::vector<uint32_t> begin(num_cells + 1, 0);
  for (const uint32_t cell : cells) {
    ++begin[cell + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  return begin;
}

// Descriptors in order of their cells; a counting sort.
std::vector<uint32_t> OrderByCell(std::span<const uint32_t> cells, std::vector<uint32_t> next) {
  std::vector<uint32_t> order(cells.size());
  for (size_t descriptor = 0; descriptor < cells.size(); ++descriptor) {
    order[next[cells[descriptor]]++] = static_cast<uint32_t>(descriptor);
  }
  return order;
}

}  // namespace

CellLists::CellLists(const ByteDescriptors& descriptors, std::span<const uint32_t> cells,
                     size_t num_cells)
    : scale_(descriptors.scale()),
      begin_(CellBegins(cells, num_cells)),
      descriptor_of_row_(OrderByCell(cells, begin_)),
      rows_(descriptors.rows(), scale_.stride(), descriptor_of_row_) {
  CAIRN_CHECK(cells.size() == descriptors.size(), "every descriptor has a cell");
  for (size_t cell = 0; cell < num_cells; ++cell) {
    max_cell_size_ = std::max<size_t>(max_cell_size_, begin_[cell + 1] - begin_[cell]);
  }
}

int64_t CellLists::Search(const BlockQueries& queries, std::span<const CellVisit> visits,
                          HitCollector* collector) const {
  // Visits whose memory is asked for ahead: first the bounds of the cell, then its first rows.
  constexpr size_t kBoundsAhead = 32;
  constexpr size_t kRowsAhead = 8;
  std::vector<BlockHit> hits(max_cell_size_);
  int64_t num_distances = 0;
  for (size_t i = 0; i < visits.size(); ++i) {
    if (i + kBoundsAhead < visits.size()) {
      __builtin_prefetch(&begin_[visits[i + kBoundsAhead].cell]);
    }
    if (i + kRowsAhead < visits.size()) {
      rows_.Prefetch(begin_[visits[i + kRowsAhead].cell]);
    }
    const auto [cell, query_idx] = visits[i];
    const size_t num_hits = rows_.Range(queries[query_idx], begin_[cell], begin_[cell + 1],
                                        collector->max_sq_steps(query_idx), hits.data());
    for (size_t j = 0; j < num_hits; ++j) {
      collector->Add(query_idx, descriptor_of_row_[hits[j].row], hits[j].sq_distance);
    }
    num_distances += begin_[cell + 1] - begin_[cell];
  }
  return num_distances;
}

size_t CellLists::MemoryBytes() const {
  return rows_.MemoryBytes() +
         (begin_.capacity() + descriptor_of_row_.capacity()) * sizeof(uint32_t);
}

}  // namespace cairn
