// The landmarks of a tile by place. Private to ingest/tiles.
#ifndef CAIRN_INGEST_TILES_LANDMARK_GRID_H_
#define CAIRN_INGEST_TILES_LANDMARK_GRID_H_

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "storage/tile/tile.h"

namespace cairn {

class LandmarkGrid {
 public:
  // `tile` must outlive the grid. A search visits the cells of `cell_m` that its ball touches.
  LandmarkGrid(const Tile* tile, double cell_m) : tile_(*tile), cell_m_(cell_m) {
    for (uint32_t i = 0; i < tile->num_landmarks(); ++i) {
      cells_[KeyOf(CellOf(tile->x_in_tile[i].cast<double>()))].push_back(i);
    }
  }

  // Calls visit(landmark_idx, distance_m) for each landmark within the radius.
  template <typename Visit>
  void ForEachWithin(const Eigen::Vector3d& x_in_tile, double radius_m, const Visit& visit) const {
    const Eigen::Vector3i low = CellOf(x_in_tile - Eigen::Vector3d::Constant(radius_m));
    const Eigen::Vector3i high = CellOf(x_in_tile + Eigen::Vector3d::Constant(radius_m));
    for (int x = low.x(); x <= high.x(); ++x) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int z = low.z(); z <= high.z(); ++z) {
          if (const auto cell = cells_.find(KeyOf({x, y, z})); cell != cells_.end()) {
            VisitCell(cell->second, x_in_tile, radius_m, visit);
          }
        }
      }
    }
  }

 private:
  template <typename Visit>
  void VisitCell(const std::vector<uint32_t>& landmarks, const Eigen::Vector3d& x_in_tile,
                 double radius_m, const Visit& visit) const {
    for (const uint32_t i : landmarks) {
      const double distance_m = (tile_.x_in_tile[i].cast<double>() - x_in_tile).norm();
      if (distance_m <= radius_m) {
        visit(i, distance_m);
      }
    }
  }

  Eigen::Vector3i CellOf(const Eigen::Vector3d& x_in_tile) const {
    return (x_in_tile / cell_m_).array().floor().cast<int>();
  }
  static uint64_t KeyOf(const Eigen::Vector3i& cell) {
    constexpr uint64_t kMask = (1 << 21) - 1;
    return (static_cast<uint64_t>(cell.x()) & kMask) << 42 |
           (static_cast<uint64_t>(cell.y()) & kMask) << 21 |
           (static_cast<uint64_t>(cell.z()) & kMask);
  }

  const Tile& tile_;
  const double cell_m_;
  std::unordered_map<uint64_t, std::vector<uint32_t>> cells_;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_LANDMARK_GRID_H_
