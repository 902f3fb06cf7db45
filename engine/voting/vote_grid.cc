#include "engine/voting/vote_grid.h"

namespace cairn {
namespace {

constexpr int kBorder = 1;

}  // namespace

VoteGrid::VoteGrid(const Eigen::Vector3d& min_corner, const Eigen::Vector3d& max_corner,
                   const Eigen::Vector3d& cell_m)
    : min_corner_(min_corner), cell_m_(cell_m) {
  const Eigen::Vector3d extent = (max_corner - min_corner).cwiseMax(0.0);
  const auto num_cells = [&] {
    return ((extent.array() / cell_m_.array()).floor() + 1.0 + 2.0 * kBorder).prod();
  };
  while (num_cells() > kMaxCells) {
    // Coarsens the axis with the most cells.
    int axis = 0;
    (extent.array() / cell_m_.array()).maxCoeff(&axis);
    cell_m_[axis] *= 2.0;
  }
  for (int axis = 0; axis < 3; ++axis) {
    size_[axis] = static_cast<int>(extent[axis] / cell_m_[axis]) + 1 + 2 * kBorder;
  }
}

Eigen::Vector3d VoteGrid::ToCells(const Eigen::Vector3d& position) const {
  return (position - min_corner_).cwiseQuotient(cell_m_).array() + kBorder;
}

Eigen::Vector3d VoteGrid::FromCells(const Eigen::Vector3d& cells) const {
  return min_corner_ + (cells.array() - kBorder).matrix().cwiseProduct(cell_m_);
}

}  // namespace cairn
