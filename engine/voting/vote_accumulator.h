// The accumulator of pose voting, one slice of yaw at a time.
#ifndef CAIRN_ENGINE_VOTING_VOTE_ACCUMULATOR_H_
#define CAIRN_ENGINE_VOTING_VOTE_ACCUMULATOR_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/voting/trace_rays.h"
#include "engine/voting/vote_grid.h"

namespace cairn {

// The votes of one yaw bin.
class VoteSlice {
 public:
  static constexpr int kMaxVoters = 65535;

  explicit VoteSlice(const VoteGrid& grid);

  // Casts the votes along the segments; segment i belongs to voter voters[i]. Voters are numbered
  // from 1 in ascending order; voters beyond kMaxVoters do not vote. A voter counts at most once
  // per cell. Returns the number of steps. Takes time proportional to segments and steps.
  int64_t Vote(const VoteSegments& segments, const std::vector<int>& voters);

  // Moves the counts out, smoothed over 2 x 2 x 2 cells. (*smoothed)[i] is the sum over cell i and
  // its successors in x, y and z, so it belongs to the corner that these cells share. Counts
  // saturate at kMaxCount. Leaves the slice empty. The size of *smoothed is the number of cells
  // rounded up to kBlock.
  void SmoothAndClear(std::vector<uint16_t>* smoothed);

  // Two smoothed slices can be added without overflow.
  static constexpr uint16_t kMaxCount = 4095;
  static constexpr int kBlock = 64;

 private:
  int64_t ListVoting(const VoteSegments& segments, const std::vector<int>& voters);

  const VoteGrid& grid_;
  std::vector<uint16_t> counts_;
  // The tag of each cell's last voter. Voters get new tags in each slice, so tags need clearing
  // only when they run out.
  std::vector<uint16_t> tags_;
  int last_tag_ = 0;
  // Scratch: counts of two planes smoothed along x, followed by a row of zeros.
  std::vector<uint16_t> lower_, upper_;
  // Scratch: segments with steps, and their cells and tags, one step after the other.
  std::vector<int> voting_;
  std::vector<uint32_t> voted_cells_;
  std::vector<uint16_t> voted_tags_;
};

// A cell of the smoothed accumulator.
struct VotePeak {
  int sum = 0;
  int yaw_idx = 0;
  int cell_idx = 0;
};

// Orders peaks by higher sum, then earlier yaw, then earlier cell.
bool IsBetterPeak(const VotePeak& a, const VotePeak& b);

// Keeps the cells with the highest sums of all offered slices; among equal sums, the earlier cell.
class PeakCollector {
 public:
  PeakCollector(int max_peaks, int min_sum);

  // Offers the sum of two smoothed slices, cell by cell. The size must be a multiple of kBlock.
  // Takes only maxima along x.
  void Offer(int yaw_idx, const std::vector<uint16_t>& a, const std::vector<uint16_t>& b);

  // Returns the peaks, highest first.
  std::vector<VotePeak> TakeSorted();

 private:
  void Insert(const VotePeak& peak);

  size_t max_peaks_;
  int threshold_;                       // Sums must exceed it.
  std::vector<VotePeak> heap_;          // The lowest is on top.
  std::vector<uint16_t> block_maxima_;  // Scratch.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_VOTE_ACCUMULATOR_H_
