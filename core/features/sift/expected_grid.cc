#include "core/features/sift/expected_grid.h"

#include <algorithm>

namespace cairn {
namespace {

// The larger cells of a large picture bound the memory.
float CellSidePx(int width_px, int height_px) {
  constexpr float kMinCellPx = 16.0f, kMaxCellsPerSide = 256.0f;
  return std::max(kMinCellPx, static_cast<float>(std::max(width_px, height_px)) / kMaxCellsPerSide);
}

}  // namespace

ExpectedGrid::ExpectedGrid(std::span<const ExpectedFeature> expected, int width_px, int height_px)
    : expected_(expected),
      cell_px_(CellSidePx(width_px, height_px)),
      num_columns_(static_cast<int>(static_cast<float>(width_px) / cell_px_) + 1),
      num_rows_(static_cast<int>(static_cast<float>(height_px) / cell_px_) + 1),
      cells_(static_cast<size_t>(num_columns_) * num_rows_) {
  for (int i = 0; i < static_cast<int>(expected.size()); ++i) {
    const ExpectedFeature& one = expected[i];
    const int last_row = RowOf(one.y_px + one.radius_px);
    const int last_column = ColumnOf(one.x_px + one.radius_px);
    for (int row = RowOf(one.y_px - one.radius_px); row <= last_row; ++row) {
      for (int column = ColumnOf(one.x_px - one.radius_px); column <= last_column; ++column) {
        cells_[static_cast<size_t>(row) * num_columns_ + column].push_back(i);
      }
    }
  }
}

bool ExpectedGrid::Contains(float x_px, float y_px, float scale_px) const {
  const std::vector<int>& cell = CellAt(ColumnOf(x_px), RowOf(y_px));
  return std::any_of(cell.begin(), cell.end(), [&](int i) {
    const ExpectedFeature& one = expected_[i];
    const float dx = x_px - one.x_px, dy = y_px - one.y_px;
    return scale_px >= one.min_scale_px && scale_px <= one.max_scale_px &&
           dx * dx + dy * dy <= one.radius_px * one.radius_px;
  });
}

int ExpectedGrid::ColumnOf(float x_px) const {
  return static_cast<int>(std::clamp(x_px / cell_px_, 0.0f, static_cast<float>(num_columns_ - 1)));
}

int ExpectedGrid::RowOf(float y_px) const {
  return static_cast<int>(std::clamp(y_px / cell_px_, 0.0f, static_cast<float>(num_rows_ - 1)));
}

}  // namespace cairn
