#include "engine/voting/vote_accumulator.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "engine/vector_clones.h"

namespace cairn {
namespace {

constexpr int kBorder = 1;

// pairs[i] = count of cell i + count of cell i + 1.
CAIRN_VECTOR_CLONES
void SumPairsAlongX(const uint32_t* __restrict cells, int num_cells, uint16_t* __restrict pairs) {
  const auto count = [cells](int i) { return std::min(cells[i] & 0xffffu, VoteSlice::kMaxCount); };
  for (int i = 0; i + 1 < num_cells; ++i) {
    pairs[i] = static_cast<uint16_t>(count(i) + count(i + 1));
  }
}

// sums[i] = sum of pairs over i and its successors along y and z.
CAIRN_VECTOR_CLONES
void SumSquaresAlongYz(const uint16_t* __restrict pairs, int num_cells, int stride_y, int stride_z,
                       uint16_t* __restrict sums) {
  const uint16_t* pairs_y = pairs + stride_y;
  const uint16_t* pairs_z = pairs + stride_z;
  const uint16_t* pairs_yz = pairs + stride_y + stride_z;
  for (int i = 0; i < num_cells; ++i) {
    sums[i] = static_cast<uint16_t>(pairs[i] + pairs_y[i] + pairs_z[i] + pairs_yz[i]);
  }
}

// Adds two rows; returns the largest sum.
CAIRN_VECTOR_CLONES
int AddRows(const uint16_t* __restrict a, const uint16_t* __restrict b, int size,
            uint16_t* __restrict sums) {
  uint16_t largest = 0;
  for (int i = 0; i < size; ++i) {
    sums[i] = static_cast<uint16_t>(a[i] + b[i]);
    largest = std::max(largest, sums[i]);
  }
  return largest;
}

}  // namespace

// Position decides between equal sums, so that the result does not depend on the heap.
bool IsBetterPeak(const VotePeak& a, const VotePeak& b) {
  return std::tuple(-a.sum, a.yaw_idx, a.cell_idx) < std::tuple(-b.sum, b.yaw_idx, b.cell_idx);
}

VoteGrid::VoteGrid(const Eigen::Vector3d& min_corner, const Eigen::Vector3d& max_corner,
                   const Eigen::Vector3d& cell_m)
    : min_corner_(min_corner), cell_m_(cell_m) {
  const Eigen::Vector3d extent = (max_corner - min_corner).cwiseMax(0.0);
  const auto num_cells = [&] {
    return ((extent.array() / cell_m_.array()).floor() + 1.0 + 2.0 * kBorder).prod();
  };
  while (num_cells() > kMaxCells) {
    // Coarsens the axis with most cells.
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

VoteSlice::VoteSlice(const VoteGrid& grid)
    : grid_(grid),
      cells_(grid.num_cells(), 0),
      pairs_(grid.num_cells() + grid.strides()[1] + grid.strides()[2], 0) {}

int VoteSlice::Vote(uint32_t voter, const Eigen::Vector3d& begin, const Eigen::Vector3d& end) {
  constexpr int kFractionBits = 32;  // Fixed-point positions: no conversion in the loop.
  constexpr double kOne = static_cast<double>(int64_t{1} << kFractionBits);
  const Eigen::Vector3d first = grid_.ToCells(begin);
  const Eigen::Vector3d length = grid_.ToCells(end) - first;
  const int num_steps = static_cast<int>(length.cwiseAbs().maxCoeff()) + 1;
  const Eigen::Vector3d step = length / num_steps;
  const auto fixed = [](double value) { return static_cast<int64_t>(value * kOne); };
  const int64_t dx = fixed(step.x()), dy = fixed(step.y()), dz = fixed(step.z());
  int64_t x = fixed(first.x()) + dx / 2, y = fixed(first.y()) + dy / 2,
          z = fixed(first.z()) + dz / 2;
  const int64_t stride_y = grid_.strides()[1], stride_z = grid_.strides()[2];
  for (int i = 0; i < num_steps; ++i) {
    uint32_t& cell = cells_[(z >> kFractionBits) * stride_z + (y >> kFractionBits) * stride_y +
                            (x >> kFractionBits)];
    const uint32_t count = cell & 0xffffu;
    const uint32_t is_new = (cell >> 16) != voter;
    cell = voter << 16 | (count + is_new);
    x += dx, y += dy, z += dz;
  }
  return num_steps;
}

void VoteSlice::SmoothAndClear(std::vector<uint16_t>* smoothed) {
  const int num_cells = grid_.num_cells();
  smoothed->resize(num_cells);
  SumPairsAlongX(cells_.data(), num_cells, pairs_.data());
  SumSquaresAlongYz(pairs_.data(), num_cells, grid_.strides()[1], grid_.strides()[2],
                    smoothed->data());
  std::fill(cells_.begin(), cells_.end(), 0u);
}

PeakCollector::PeakCollector(const VoteGrid& grid, int max_peaks, int min_sum)
    : grid_(grid),
      max_peaks_(max_peaks),
      threshold_(std::max(0, min_sum - 1)),
      sums_(grid.size()[0]) {}

void PeakCollector::Offer(int yaw_idx, const std::vector<uint16_t>& a,
                          const std::vector<uint16_t>& b) {
  const int row_size = grid_.size()[0];
  // The last cell of a row is border: no corner there.
  for (int begin = 0; begin < grid_.num_cells(); begin += row_size) {
    if (AddRows(&a[begin], &b[begin], row_size, sums_.data()) <= threshold_) {
      continue;
    }
    for (int x = 0; x + 1 < row_size; ++x) {
      const int left = x > 0 ? sums_[x - 1] : 0;
      if (sums_[x] > threshold_ && sums_[x] > left && sums_[x] >= sums_[x + 1]) {
        Insert({sums_[x], yaw_idx, begin + x});
      }
    }
  }
}

void PeakCollector::Insert(const VotePeak& peak) {
  if (heap_.size() == max_peaks_) {
    std::pop_heap(heap_.begin(), heap_.end(), IsBetterPeak);
    heap_.pop_back();
  }
  heap_.push_back(peak);
  std::push_heap(heap_.begin(), heap_.end(), IsBetterPeak);
  if (heap_.size() == max_peaks_) {
    threshold_ = std::max(threshold_, heap_.front().sum);
  }
}

std::vector<VotePeak> PeakCollector::TakeSorted() {
  std::sort(heap_.begin(), heap_.end(), IsBetterPeak);
  return std::move(heap_);
}

}  // namespace cairn
