// The cells of pose voting.
#ifndef CAIRN_ENGINE_VOTING_VOTE_GRID_H_
#define CAIRN_ENGINE_VOTING_VOTE_GRID_H_

#include <Eigen/Core>
#include <array>

namespace cairn {

// Regular cells over a box of camera positions. Dense, with a border of empty cells all around.
class VoteGrid {
 public:
  // Cells of at least `cell_m` (x, y, z) over the box; doubled until there are at most kMaxCells,
  // so that memory is bounded whatever the region.
  VoteGrid(const Eigen::Vector3d& min_corner, const Eigen::Vector3d& max_corner,
           const Eigen::Vector3d& cell_m);

  static constexpr int kMaxCells = 1 << 20;

  const Eigen::Vector3d& cell_m() const { return cell_m_; }
  int num_cells() const { return size_[0] * size_[1] * size_[2]; }
  // Border included; x runs fastest.
  const std::array<int, 3>& size() const { return size_; }
  std::array<int, 3> strides() const { return {1, size_[0], size_[0] * size_[1]}; }

  // Position in units of cells, border included: its floor is the cell.
  Eigen::Vector3d ToCells(const Eigen::Vector3d& position) const;
  // Inverse of ToCells.
  Eigen::Vector3d FromCells(const Eigen::Vector3d& cells) const;

 private:
  Eigen::Vector3d min_corner_;  // Of the first cell that is not border.
  Eigen::Vector3d cell_m_;
  std::array<int, 3> size_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_VOTE_GRID_H_
