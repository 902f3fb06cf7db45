#include "engine/voting/vote_accumulator.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "core/simd.h"

namespace cairn {
namespace {

// pairs[i] = count of cell i + count of cell i + 1. Clears cells 0 ... size - 1.
CAIRN_VECTOR_CLONES
void MovePairsAlongX(uint16_t* __restrict counts, int size, uint16_t* __restrict pairs) {
  const auto capped = [](uint16_t count) { return std::min(count, VoteSlice::kMaxCount); };
  for (int i = 0; i < size; ++i) {
    pairs[i] = static_cast<uint16_t>(capped(counts[i]) + capped(counts[i + 1]));
    counts[i] = 0;
  }
}

// sums[i] = sum of pairs over i and its successors along y, in two planes.
CAIRN_VECTOR_CLONES
void SumSquaresAlongYz(const uint16_t* __restrict lower, const uint16_t* __restrict upper, int size,
                       int stride_y, uint16_t* __restrict sums) {
  for (int i = 0; i < size; ++i) {
    sums[i] =
        static_cast<uint16_t>(lower[i] + lower[i + stride_y] + upper[i] + upper[i + stride_y]);
  }
}

// maxima[i] = the largest sum of two smoothed slices in block i.
CAIRN_VECTOR_CLONES
void MaximaOfBlocks(const uint16_t* __restrict a, const uint16_t* __restrict b, int num_blocks,
                    uint16_t* __restrict maxima) {
  for (int block = 0; block < num_blocks; ++block) {
    uint16_t largest = 0;
    for (int i = block * VoteSlice::kBlock; i < (block + 1) * VoteSlice::kBlock; ++i) {
      largest = std::max(largest, static_cast<uint16_t>(a[i] + b[i]));
    }
    maxima[block] = largest;
  }
}

// Cells are written in whole vectors, so up to kLanes - 1 elements beyond the last are written.
constexpr int kLanes = 16;

// Lists the cells of all steps of the listed segments, one step after the other, with the tag of
// each step's voter: voter number plus `first_tag`.
CAIRN_VECTOR_CLONES
void ListCells(const VoteSegments& segments, const int* segment_idxs, int num_listed,
               const int* voters, int first_tag, int stride_y, int stride_z,
               uint32_t* __restrict cells, uint16_t* __restrict tags) {
  for (int listed = 0; listed < num_listed; ++listed) {
    const int i = segment_idxs[listed];
    const int num_steps = segments.num_steps[i];
    const uint16_t tag = static_cast<uint16_t>(first_tag + voters[i]);
    const float x = segments.x[i], y = segments.y[i], z = segments.z[i];
    const float step_x = segments.step_x[i], step_y = segments.step_y[i];
    const float step_z = segments.step_z[i];
    for (int begin = 0; begin < num_steps; begin += kLanes) {
      for (int lane = 0; lane < kLanes; ++lane) {
        const float step = static_cast<float>(begin + lane);
        cells[begin + lane] =
            static_cast<uint32_t>(static_cast<int32_t>(x + step * step_x) +
                                  static_cast<int32_t>(y + step * step_y) * stride_y +
                                  static_cast<int32_t>(z + step * step_z) * stride_z);
        tags[begin + lane] = tag;
      }
    }
    cells += num_steps;
    tags += num_steps;
  }
}

}  // namespace

// Compares positions if sums are equal, so that the result does not depend on the heap.
bool IsBetterPeak(const VotePeak& a, const VotePeak& b) {
  return std::tuple(-a.sum, a.yaw_idx, a.cell_idx) < std::tuple(-b.sum, b.yaw_idx, b.cell_idx);
}

VoteSlice::VoteSlice(const VoteGrid& grid)
    : grid_(grid),
      counts_(grid.num_cells() + 1, 0),
      tags_(grid.num_cells(), 0),
      lower_(grid.strides()[2] + grid.strides()[1], 0),
      upper_(grid.strides()[2] + grid.strides()[1], 0) {}

// Lists the segments that have steps; returns their number.
int64_t VoteSlice::ListVoting(const VoteSegments& segments, const std::vector<int>& voters) {
  const int size = static_cast<int>(voters.size());
  voting_.resize(size + 1);
  int64_t num_steps = 0;
  int num_voting = 0;
  for (int i = 0; i < size && voters[i] <= kMaxVoters; ++i) {
    voting_[num_voting] = i;
    // Most segments have no steps, at random, so a branch would be mispredicted.
    num_voting += segments.num_steps[i] > 0;
    num_steps += segments.num_steps[i];
  }
  voting_.resize(num_voting);
  return num_steps;
}

int64_t VoteSlice::Vote(const VoteSegments& segments, const std::vector<int>& voters) {
  const int num_voters = voters.empty() ? 0 : std::min(voters.back(), kMaxVoters);
  if (num_voters > kMaxVoters - last_tag_) {
    std::fill(tags_.begin(), tags_.end(), uint16_t{0});
    last_tag_ = 0;
  }
  const int64_t num_steps = ListVoting(segments, voters);
  voted_cells_.resize(num_steps + kLanes);
  voted_tags_.resize(num_steps + kLanes);
  ListCells(segments, voting_.data(), static_cast<int>(voting_.size()), voters.data(), last_tag_,
            grid_.strides()[1], grid_.strides()[2], voted_cells_.data(), voted_tags_.data());
  last_tag_ += num_voters;
  for (int64_t i = 0; i < num_steps; ++i) {
    const uint32_t cell = voted_cells_[i];
    counts_[cell] += tags_[cell] != voted_tags_[i];
    tags_[cell] = voted_tags_[i];
  }
  return num_steps;
}

void VoteSlice::SmoothAndClear(std::vector<uint16_t>* smoothed) {
  const int num_planes = grid_.size()[2], plane_size = grid_.strides()[2];
  smoothed->resize((grid_.num_cells() + kBlock - 1) / kBlock * kBlock, 0);
  const auto clear = [plane_size](std::vector<uint16_t>* plane) {
    std::fill_n(plane->begin(), plane_size, uint16_t{0});
  };
  clear(&lower_);  // The first and the last plane are border, without votes.
  for (int plane = 0; plane + 1 < num_planes; ++plane) {
    if (plane + 1 < num_planes - 1) {
      MovePairsAlongX(&counts_[(plane + 1) * plane_size], plane_size, upper_.data());
    } else {
      clear(&upper_);
    }
    SumSquaresAlongYz(lower_.data(), upper_.data(), plane_size, grid_.strides()[1],
                      smoothed->data() + plane * plane_size);
    std::swap(lower_, upper_);
  }
}

PeakCollector::PeakCollector(int max_peaks, int min_sum)
    : max_peaks_(max_peaks), threshold_(std::max(0, min_sum - 1)) {}

void PeakCollector::Offer(int yaw_idx, const std::vector<uint16_t>& a,
                          const std::vector<uint16_t>& b) {
  constexpr int kBlock = VoteSlice::kBlock;
  const int num_blocks = static_cast<int>(a.size()) / kBlock;
  block_maxima_.resize(num_blocks);
  MaximaOfBlocks(a.data(), b.data(), num_blocks, block_maxima_.data());
  // The ends of rows are border cells without votes, so the neighbors in memory are the neighbors
  // along x.
  const auto sum = [&](int i) { return i >= 0 && i < num_blocks * kBlock ? a[i] + b[i] : 0; };
  for (int block = 0; block < num_blocks; ++block) {
    if (block_maxima_[block] <= threshold_) {
      continue;
    }
    for (int i = block * kBlock; i < (block + 1) * kBlock; ++i) {
      if (sum(i) > threshold_ && sum(i) > sum(i - 1) && sum(i) >= sum(i + 1)) {
        Insert({sum(i), yaw_idx, i});
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
