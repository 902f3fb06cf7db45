// The cells of pose voting.
#ifndef CAIRN_ENGINE_VOTING_VOTE_GRID_H_
#define CAIRN_ENGINE_VOTING_VOTE_GRID_H_

#include <Eigen/Core>
#include <array>

namespace cairn {

// Regular cells over a box of camera positions. The grid is dense and has a border of empty cells.
class VoteGrid {
 public:
  // Makes cells of at least `cell_m` (x, y, z) over the box. Cells are doubled until there are at
  // most kMaxCells, so memory is bounded for any region.
  VoteGrid(const Eigen::Vector3d& min_corner, const Eigen::Vector3d& max_corner,
           const Eigen::Vector3d& cell_m);

  static constexpr int kMaxCells = 1 << 20;

  const Eigen::Vector3d& cell_m() const { return cell_m_; }
  int num_cells() const { return size_[0] * size_[1] * size_[2]; }
  // Includes the border; x varies fastest.
  const std::array<int, 3>& size() const { return size_; }
  std::array<int, 3> strides() const { return {1, size_[0], size_[0] * size_[1]}; }

  // Converts a position to units of cells, border included. Its floor is the cell.
  Eigen::Vector3d ToCells(const Eigen::Vector3d& position) const;
  // The inverse of ToCells.
  Eigen::Vector3d FromCells(const Eigen::Vector3d& cells) const;

 private:
  Eigen::Vector3d min_corner_;  // Of the first cell inside the border.
  Eigen::Vector3d cell_m_;
  std::array<int, 3> size_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_VOTE_GRID_H_
