#include "engine/matching/cell_lists.h"

#include <algorithm>
#include <cstring>

#include "core/check.h"
#include "engine/matching/distance_kernels.h"

namespace cairn {

CellLists::CellLists(const ByteDescriptors& descriptors, std::span<const uint32_t> cells,
                     size_t num_cells)
    : scale_(descriptors.scale()),
      begin_(num_cells + 1, 0),
      rows_(descriptors.size() * scale_.stride()),
      descriptor_of_row_(descriptors.size()) {
  CAIRN_CHECK(cells.size() == descriptors.size(), "every descriptor has a cell");
  for (const uint32_t cell : cells) {
    ++begin_[cell + 1];
  }
  for (size_t cell = 0; cell < num_cells; ++cell) {
    max_cell_size_ = std::max(max_cell_size_, size_t{begin_[cell + 1]});
    begin_[cell + 1] += begin_[cell];
  }
  std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
  const size_t stride = scale_.stride();
  for (size_t descriptor = 0; descriptor < cells.size(); ++descriptor) {
    const uint32_t row = next[cells[descriptor]]++;
    descriptor_of_row_[row] = static_cast<uint32_t>(descriptor);
    std::memcpy(rows_.data() + row * stride, descriptors.rows() + descriptor * stride, stride);
  }
}

int64_t CellLists::Search(const std::vector<int16_t>& query_steps,
                          std::span<const CellVisit> visits, HitCollector* collector) const {
  // Visits whose memory is asked for ahead: first the bounds of the cell, then its rows.
  constexpr size_t kBoundsAhead = 32;
  constexpr size_t kRowsAhead = 8;
  const DistanceKernels& kernels = BestDistanceKernels();
  const size_t stride = scale_.stride();
  std::vector<int32_t> sq_steps(max_cell_size_);
  int64_t num_distances = 0;
  for (size_t i = 0; i < visits.size(); ++i) {
    if (i + kBoundsAhead < visits.size()) {
      __builtin_prefetch(&begin_[visits[i + kBoundsAhead].cell]);
    }
    if (i + kRowsAhead < visits.size()) {
      __builtin_prefetch(rows_.data() + begin_[visits[i + kRowsAhead].cell] * stride);
    }
    const auto [cell, query_idx] = visits[i];
    const size_t begin = begin_[cell];
    const size_t count = begin_[cell + 1] - begin;
    kernels.scan(query_steps.data() + query_idx * stride, rows_.data() + begin * stride,
                 scale_.stride(), count, sq_steps.data());
    for (size_t j = 0; j < count; ++j) {
      if (sq_steps[j] <= collector->max_sq_steps(query_idx)) {
        collector->Add(query_idx, descriptor_of_row_[begin + j], sq_steps[j]);
      }
    }
    num_distances += static_cast<int64_t>(count);
  }
  return num_distances;
}

size_t CellLists::MemoryBytes() const {
  return rows_.capacity() + (begin_.capacity() + descriptor_of_row_.capacity()) * sizeof(uint32_t);
}

}  // namespace cairn
