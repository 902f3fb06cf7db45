// The accumulator of pose voting: one slice of yaw at a time.
#ifndef CAIRN_ENGINE_VOTING_VOTE_ACCUMULATOR_H_
#define CAIRN_ENGINE_VOTING_VOTE_ACCUMULATOR_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

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

// The votes of one yaw bin. A voter counts at most once in a cell, if its votes come in one run.
class VoteSlice {
 public:
  static constexpr int kMaxVoters = 65535;

  explicit VoteSlice(const VoteGrid& grid);

  // Votes along the segment from `begin` to `end` (positions in the box), in steps of at most a
  // cell along each axis. `voter` lies in [1, kMaxVoters]. Returns the number of steps.
  int Vote(uint32_t voter, const Eigen::Vector3d& begin, const Eigen::Vector3d& end);

  // Moves the counts out, smoothed over 2 x 2 x 2 cells: (*smoothed)[i] is the sum over cell i and
  // its successors in x, y and z, so it belongs to the corner that they share. Counts saturate at
  // kMaxCount. Leaves the slice empty.
  void SmoothAndClear(std::vector<uint16_t>* smoothed);

  // Two smoothed slices can be added without overflow.
  static constexpr uint32_t kMaxCount = 4095;

 private:
  const VoteGrid& grid_;
  std::vector<uint32_t> cells_;  // Last voter << 16 | count.
  std::vector<uint16_t> pairs_;  // Scratch: counts smoothed along x, with a tail of zeros.
};

// A cell of the smoothed accumulator.
struct VotePeak {
  int sum = 0;
  int yaw_idx = 0;
  int cell_idx = 0;
};

// Order of peaks: the higher sum, then the earlier yaw, then the earlier cell.
bool IsBetterPeak(const VotePeak& a, const VotePeak& b);

// Keeps the cells with the highest sums of all slices offered. Ties go to the earlier cell.
class PeakCollector {
 public:
  PeakCollector(const VoteGrid& grid, int max_peaks, int min_sum);

  // Offers the sum of two smoothed slices, cell by cell; only maxima along x are taken.
  void Offer(int yaw_idx, const std::vector<uint16_t>& a, const std::vector<uint16_t>& b);

  // Highest first.
  std::vector<VotePeak> TakeSorted();

 private:
  void Insert(const VotePeak& peak);

  const VoteGrid& grid_;
  size_t max_peaks_;
  int threshold_;               // Sums must exceed it.
  std::vector<VotePeak> heap_;  // The lowest on top.
  std::vector<uint16_t> sums_;  // Scratch: one row.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_VOTE_ACCUMULATOR_H_
