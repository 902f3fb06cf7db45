// Tells whether a feature is expected at a place of a picture.
#ifndef CAIRN_CORE_FEATURES_SIFT_EXPECTED_GRID_H_
#define CAIRN_CORE_FEATURES_SIFT_EXPECTED_GRID_H_

#include <cstddef>
#include <span>
#include <vector>

#include "core/expected_feature.h"

namespace cairn {

class ExpectedGrid {
 public:
  // `expected` must outlive the grid. Places outside the picture count as those on its border.
  ExpectedGrid(std::span<const ExpectedFeature> expected, int width_px, int height_px);

  // True if a keypoint of this scale is expected here.
  bool Contains(float x_px, float y_px, float scale_px) const;

 private:
  int ColumnOf(float x_px) const;
  int RowOf(float y_px) const;
  const std::vector<int>& CellAt(int column, int row) const {
    return cells_[static_cast<size_t>(row) * num_columns_ + column];
  }

  std::span<const ExpectedFeature> expected_;
  float cell_px_ = 0.0f;
  int num_columns_ = 0;
  int num_rows_ = 0;
  std::vector<std::vector<int>> cells_;  // The expected features that reach into each cell.
};

}  // namespace cairn

#endif  // CAIRN_CORE_FEATURES_SIFT_EXPECTED_GRID_H_
