#include "engine/voting/vote_accumulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

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

TEST(VoteGrid, CoversTheBoxWithABorder) {
  const VoteGrid grid({-10, -20, 0}, {10, 20, 5}, {2, 2, 2});
  EXPECT_EQ(grid.size(), (std::array<int, 3>{13, 23, 5}));
  EXPECT_TRUE(grid.ToCells({-10, -20, 0}).isApprox(Vector3d(1, 1, 1)));
  EXPECT_TRUE(grid.FromCells(grid.ToCells({3, 4, 1})).isApprox(Vector3d(3, 4, 1)));
}

TEST(VoteGrid, CoarsensWhatWouldNotFit) {
  const VoteGrid grid({-50'000, -50'000, -10'000}, {50'000, 50'000, 10'000}, {2, 2, 2});
  EXPECT_LE(grid.num_cells(), VoteGrid::kMaxCells);
  EXPECT_GT(grid.num_cells(), VoteGrid::kMaxCells / 16);
  EXPECT_GT(grid.cell_m().x(), 2.0);
}

TEST(VoteGrid, SurvivesAnEmptyBox) {
  const VoteGrid grid({5, 5, 5}, {-5, -5, -5}, {2, 2, 2});
  EXPECT_EQ(grid.num_cells(), 27);
}

TEST(VoteSlice, VoterCountsOncePerCell) {
  const VoteGrid grid({0, 0, 0}, {20, 2, 2}, {2, 2, 2});
  VoteSlice slice(grid);
  EXPECT_EQ(slice.Vote(1, {1, 1, 1}, {15, 1, 1}), 8);
  slice.Vote(1, {9, 1, 1}, {1, 1, 1});
  slice.Vote(2, {1, 1, 1}, {1, 1, 1});
  std::vector<uint16_t> smoothed;
  slice.SmoothAndClear(&smoothed);
  // The sum belongs to a cell and its successors: two cells along x, one along y and z.
  const int first = CellIndex(grid, {1, 1, 1});
  EXPECT_EQ(smoothed[first], 3);      // Both voters, then the first alone.
  EXPECT_EQ(smoothed[first + 1], 2);  // The first voter in two cells.
  EXPECT_EQ(smoothed[first - 1], 2);
}

TEST(VoteSlice, SmoothingSpreadsOneVoteOverEightCorners) {
  const VoteGrid grid({0, 0, 0}, {8, 8, 8}, {2, 2, 2});
  VoteSlice slice(grid);
  slice.Vote(1, {5, 5, 5}, {5, 5, 5});
  std::vector<uint16_t> smoothed;
  slice.SmoothAndClear(&smoothed);
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
  slice.Vote(1, {1, 1, 1}, {7, 7, 7});
  std::vector<uint16_t> smoothed;
  slice.SmoothAndClear(&smoothed);
  slice.SmoothAndClear(&smoothed);
  EXPECT_THAT(smoothed, ::testing::Each(0));
}

TEST(VoteSlice, SegmentsToTheCornersOfTheBoxStayInside) {
  const VoteGrid grid({-9, -9, -3}, {9, 9, 3}, {2, 2, 2});
  VoteSlice slice(grid);
  uint32_t voter = 0;
  for (const double x : {-9.0, 9.0}) {
    for (const double y : {-9.0, 9.0}) {
      for (const double z : {-3.0, 3.0}) {
        slice.Vote(++voter, {x, y, z}, {-x, -y, -z});
        slice.Vote(++voter, {x, y, z}, {x, y, z});
      }
    }
  }
  std::vector<uint16_t> smoothed;
  slice.SmoothAndClear(&smoothed);
  EXPECT_GT(*std::max_element(smoothed.begin(), smoothed.end()), 8);  // The centre.
}

TEST(PeakCollector, KeepsTheHighestInOrder) {
  const VoteGrid grid({0, 0, 0}, {18, 18, 2}, {2, 2, 2});
  PeakCollector peaks(grid, 2, 3);
  std::vector<uint16_t> a(grid.num_cells(), 0), b(grid.num_cells(), 0);
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
  PeakCollector peaks(grid, 10, 1);
  std::vector<uint16_t> a(grid.num_cells(), 0);
  const std::vector<uint16_t> none(grid.num_cells(), 0);
  a[2] = 5, a[3] = 8, a[4] = 8, a[5] = 3;
  peaks.Offer(0, a, none);
  const auto sorted = peaks.TakeSorted();
  ASSERT_THAT(sorted, SizeIs(1));
  EXPECT_EQ(sorted[0].cell_idx, 3);
}

TEST(PeakCollector, NothingFromAnEmptyAccumulator) {
  const VoteGrid grid({0, 0, 0}, {18, 2, 2}, {2, 2, 2});
  PeakCollector peaks(grid, 10, 0);
  const std::vector<uint16_t> none(grid.num_cells(), 0);
  peaks.Offer(0, none, none);
  EXPECT_THAT(peaks.TakeSorted(), IsEmpty());
}

}  // namespace
}  // namespace cairn
