#include "engine/refinement/landmark_table.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace cairn {
namespace {

TEST(LandmarkTable, NumbersInOrderOfInsertion) {
  LandmarkTable table(3);
  EXPECT_EQ(table.Insert(LandmarkId(70)), 0);
  EXPECT_EQ(table.Insert(LandmarkId(5)), 1);
  EXPECT_EQ(table.Insert(LandmarkId(70)), 0);
  EXPECT_EQ(table.size(), 2);
  EXPECT_EQ(table.Find(LandmarkId(5)), 1);
  EXPECT_EQ(table.Find(LandmarkId(6)), -1);
}

TEST(LandmarkTable, EmptyTableFindsNothing) {
  const LandmarkTable table(0);
  EXPECT_EQ(table.Find(LandmarkId(1)), -1);
  EXPECT_EQ(table.size(), 0);
}

TEST(LandmarkTable, AgreesWithMapAtFullLoad) {
  constexpr int kSize = 5000;
  std::mt19937_64 random(1);
  std::map<uint64_t, int> expected;
  LandmarkTable table(kSize);
  for (int i = 0; i < kSize; ++i) {
    const uint64_t id = 1 + random() % 20'000;  // Dense, so that many repeat or are adjacent.
    const auto [entry, is_new] = expected.emplace(id, static_cast<int>(expected.size()));
    EXPECT_EQ(table.Insert(LandmarkId(id)), entry->second);
  }
  for (uint64_t id = 1; id <= 20'000; ++id) {
    const auto entry = expected.find(id);
    EXPECT_EQ(table.Find(LandmarkId(id)), entry == expected.end() ? -1 : entry->second);
  }
}

TEST(LandmarkTable, MarksLandmarksOfTile) {
  LandmarkTable table(2);
  table.Insert(LandmarkId(9));
  table.Insert(LandmarkId(7));
  Tile tile;
  tile.landmark_ids = {LandmarkId(7), LandmarkId(8), LandmarkId(9)};
  tile.x_in_tile.resize(3);
  const LandmarkMarks marks = table.Mark(tile);
  EXPECT_TRUE(marks.Has(0));
  EXPECT_FALSE(marks.Has(1));
  EXPECT_TRUE(marks.Has(2));
}

}  // namespace
}  // namespace cairn
