#include "engine/voting/vote_accumulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <set>
#include <vector>

namespace cairn {
namespace {

using Eigen::Vector3d;
using ::testing::IsEmpty;
using ::testing::SizeIs;

int CellIndex(const VoteGrid& grid, const Vector3d& position) {
  const Vector3d cells = grid.ToCells(position);
  const auto strides = grid.strides();
  return static_cast<int>(cells.x()) * strides[0] + static_cast<int>(cells.y()) * strides[1] +
         static_cast<int>(cells.z()) * strides[2];
}

// Segments between positions in the box, as many steps as needed, one after the other.
class SegmentsBuilder {
 public:
  explicit SegmentsBuilder(const VoteGrid& grid) : grid_(grid) {}

  void Add(int voter, const Vector3d& begin, const Vector3d& end) {
    const Eigen::Vector3f first = grid_.ToCells(begin).cast<float>();
    const Eigen::Vector3f length = grid_.ToCells(end).cast<float>() - first;
    const int num_steps = static_cast<int>(length.cwiseAbs().maxCoeff()) + 1;
    const Eigen::Vector3f step = length / static_cast<float>(num_steps);
    voters.push_back(voter);
    segments.num_steps.push_back(num_steps);
    segments.x.push_back(first.x() + 0.5f * step.x());
    segments.y.push_back(first.y() + 0.5f * step.y());
    segments.z.push_back(first.z() + 0.5f * step.z());
    segments.step_x.push_back(step.x());
    segments.step_y.push_back(step.y());
    segments.step_z.push_back(step.z());
  }

  VoteSegments segments = VoteSegments(0);
  std::vector<int> voters;

 private:
  const VoteGrid& grid_;
};

std::vector<uint16_t> Smoothed(const SegmentsBuilder& votes, VoteSlice* slice) {
  std::vector<uint16_t> smoothed;
  slice->Vote(votes.segments, votes.voters);
  slice->SmoothAndClear(&smoothed);
  return smoothed;
}

TEST(VoteSlice, VoterCountsOncePerCell) {
  const VoteGrid grid({0, 0, 0}, {20, 2, 2}, {2, 2, 2});
  VoteSlice slice(grid);
  SegmentsBuilder votes(grid);
  votes.Add(1, {1, 1, 1}, {15, 1, 1});
  votes.Add(1, {9, 1, 1}, {1, 1, 1});
  votes.Add(2, {1, 1, 1}, {1, 1, 1});
  EXPECT_EQ(slice.Vote(votes.segments, votes.voters), 8 + 5 + 1);
  std::vector<uint16_t> smoothed;
  slice.SmoothAndClear(&smoothed);
  // The sum belongs to a cell and its successors: two cells along x, one along y and z.
  const int first = CellIndex(grid, {1, 1, 1});
  EXPECT_EQ(smoothed[first], 3);      // Both voters, then the first alone.
  EXPECT_EQ(smoothed[first + 1], 2);  // The first voter in two cells.
  EXPECT_EQ(smoothed[first - 1], 2);
}

TEST(VoteSlice, CountsAsASetOfVotersPerCellWould) {
  const VoteGrid grid({-9, -9, -3}, {9, 9, 3}, {2, 2, 2});
  VoteSlice slice(grid);
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto inside = [&] {
    return Vector3d(9 * uniform(engine), 9 * uniform(engine), 3 * uniform(engine));
  };
  for (int round = 0; round < 3; ++round) {  // What is left of one round must not show in the next.
    SegmentsBuilder votes(grid);
    for (int i = 0; i < 200; ++i) {
      votes.Add(1 + i / 3, inside(), inside());
    }
    std::vector<std::set<int>> voters_of_cell(grid.num_cells());
    for (size_t i = 0; i < votes.voters.size(); ++i) {
      const VoteSegments& s = votes.segments;
      for (int step = 0; step < s.num_steps[i]; ++step) {
        const auto at = [step](float first, float by) {
          return static_cast<int>(first + static_cast<float>(step) * by);
        };
        voters_of_cell[at(s.x[i], s.step_x[i]) + at(s.y[i], s.step_y[i]) * grid.strides()[1] +
                       at(s.z[i], s.step_z[i]) * grid.strides()[2]]
            .insert(votes.voters[i]);
      }
    }
    const std::vector<uint16_t> smoothed = Smoothed(votes, &slice);
    const auto strides = grid.strides();
    for (int cell = 0; cell + strides[0] + strides[1] + strides[2] < grid.num_cells(); ++cell) {
      size_t expected = 0;
      for (int corner = 0; corner < 8; ++corner) {
        expected += voters_of_cell[cell + (corner & 1) * strides[0] +
                                   (corner >> 1 & 1) * strides[1] + (corner >> 2 & 1) * strides[2]]
                        .size();
      }
      EXPECT_EQ(smoothed[cell], expected);
    }
  }
}

TEST(VoteSlice, VotersOfManySlicesDoNotMixUp) {
  const VoteGrid grid({0, 0, 0}, {2, 2, 2}, {2, 2, 2});
  VoteSlice slice(grid);
  const int cell = CellIndex(grid, {1, 1, 1});
  SegmentsBuilder votes(grid);
  for (int voter = 1; voter <= 3000; ++voter) {
    votes.Add(voter, {1, 1, 1}, {1, 1, 1});
    votes.Add(voter, {1, 1, 1}, {1, 1, 1});
  }
  for (int round = 0; round < 50; ++round) {  // Three times as many voters as there are tags.
    EXPECT_EQ(Smoothed(votes, &slice)[cell], 3000);
  }
}

TEST(VoteSlice, VotersBeyondTheLastTagDoNotVote) {
  const VoteGrid grid({0, 0, 0}, {6, 2, 2}, {2, 2, 2});
  VoteSlice slice(grid);
  SegmentsBuilder votes(grid);
  votes.Add(VoteSlice::kMaxVoters, {1, 1, 1}, {1, 1, 1});
  votes.Add(VoteSlice::kMaxVoters + 1, {5, 1, 1}, {5, 1, 1});
  const std::vector<uint16_t> smoothed = Smoothed(votes, &slice);
  EXPECT_EQ(smoothed[CellIndex(grid, {1, 1, 1})], 1);
  EXPECT_EQ(smoothed[CellIndex(grid, {5, 1, 1})], 0);
}

TEST(VoteSlice, CountsSaturate) {
  const VoteGrid grid({0, 0, 0}, {2, 2, 2}, {2, 2, 2});
  VoteSlice slice(grid);
  SegmentsBuilder votes(grid);
  for (int voter = 1; voter <= VoteSlice::kMaxCount + 10; ++voter) {
    votes.Add(voter, {1, 1, 1}, {1, 1, 1});
  }
  EXPECT_EQ(Smoothed(votes, &slice)[CellIndex(grid, {1, 1, 1})], VoteSlice::kMaxCount);
}

TEST(VoteSlice, SmoothingSpreadsOneVoteOverEightCorners) {
  const VoteGrid grid({0, 0, 0}, {8, 8, 8}, {2, 2, 2});
  VoteSlice slice(grid);
  SegmentsBuilder votes(grid);
  votes.Add(1, {5, 5, 5}, {5, 5, 5});
  const std::vector<uint16_t> smoothed = Smoothed(votes, &slice);
  EXPECT_EQ(std::accumulate(smoothed.begin(), smoothed.end(), 0), 8);
  const int cell = CellIndex(grid, {5, 5, 5});
  const auto strides = grid.strides();
  for (int corner = 0; corner < 8; ++corner) {
    EXPECT_EQ(smoothed[cell - (corner & 1) * strides[0] - (corner >> 1 & 1) * strides[1] -
                       (corner >> 2 & 1) * strides[2]],
              1);
  }
}

TEST(VoteSlice, IsEmptyAfterSmoothing) {
  const VoteGrid grid({0, 0, 0}, {8, 8, 8}, {2, 2, 2});
  VoteSlice slice(grid);
  SegmentsBuilder votes(grid);
  votes.Add(1, {1, 1, 1}, {7, 7, 7});
  std::vector<uint16_t> smoothed = Smoothed(votes, &slice);
  slice.SmoothAndClear(&smoothed);
  EXPECT_THAT(smoothed, ::testing::Each(0));
}

TEST(VoteSlice, SegmentsWithoutStepsDoNotVote) {
  const VoteGrid grid({0, 0, 0}, {8, 8, 8}, {2, 2, 2});
  VoteSlice slice(grid);
  SegmentsBuilder votes(grid);
  votes.Add(1, {1, 1, 1}, {7, 7, 7});
  votes.segments.num_steps[0] = 0;
  EXPECT_THAT(Smoothed(votes, &slice), ::testing::Each(0));
}

// A slice of zeros, as smoothing leaves it.
std::vector<uint16_t> EmptySlice(const VoteGrid& grid) {
  std::vector<uint16_t> smoothed;
  VoteSlice(grid).SmoothAndClear(&smoothed);
  return smoothed;
}

TEST(PeakCollector, KeepsTheHighestInOrder) {
  const VoteGrid grid({0, 0, 0}, {18, 18, 2}, {2, 2, 2});
  PeakCollector peaks(2, 3);
  std::vector<uint16_t> a = EmptySlice(grid), b = EmptySlice(grid);
  const int row = grid.strides()[1];
  a[3 * row + 2] = 4;
  b[3 * row + 2] = 1;
  a[5 * row + 4] = 9;
  b[7 * row + 6] = 7;
  a[8 * row + 8] = 2;  // Below the least sum.
  peaks.Offer(5, a, b);
  const auto sorted = peaks.TakeSorted();
  ASSERT_THAT(sorted, SizeIs(2));
  EXPECT_EQ(sorted[0].sum, 9);
  EXPECT_EQ(sorted[0].cell_idx, 5 * row + 4);
  EXPECT_EQ(sorted[1].sum, 7);
  EXPECT_EQ(sorted[1].yaw_idx, 5);
}

TEST(PeakCollector, TakesMaximaAlongXOnly) {
  const VoteGrid grid({0, 0, 0}, {18, 2, 2}, {2, 2, 2});
  PeakCollector peaks(10, 1);
  std::vector<uint16_t> a = EmptySlice(grid);
  const std::vector<uint16_t> none = EmptySlice(grid);
  a[2] = 5, a[3] = 8, a[4] = 8, a[5] = 3;
  peaks.Offer(0, a, none);
  const auto sorted = peaks.TakeSorted();
  ASSERT_THAT(sorted, SizeIs(1));
  EXPECT_EQ(sorted[0].cell_idx, 3);
}

TEST(PeakCollector, NothingFromAnEmptyAccumulator) {
  const VoteGrid grid({0, 0, 0}, {18, 2, 2}, {2, 2, 2});
  PeakCollector peaks(10, 0);
  const std::vector<uint16_t> none = EmptySlice(grid);
  peaks.Offer(0, none, none);
  EXPECT_THAT(peaks.TakeSorted(), IsEmpty());
}

}  // namespace
}  // namespace cairn
