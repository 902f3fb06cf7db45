#include "engine/voting/vote_grid.h"

#include <gtest/gtest.h>

#include <array>

namespace cairn {
namespace {

using Eigen::Vector3d;

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

}  // namespace
}  // namespace cairn
