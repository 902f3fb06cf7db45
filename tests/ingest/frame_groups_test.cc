#include "ingest/anchor/frame_groups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace cairn {
namespace {

using Groups = std::vector<std::vector<size_t>>;

// Frames stand in a row, 3 m from each other; those up to 30 m apart are near.
std::vector<FramePair> RowOf(size_t num_frames, const std::function<bool(size_t, size_t)>& agree) {
  std::vector<FramePair> pairs;
  for (size_t a = 0; a < num_frames; ++a) {
    for (size_t b = a + 1; b < num_frames && b <= a + 10; ++b) {
      pairs.push_back({a, b, 3.0 * static_cast<double>(b - a), agree(a, b)});
    }
  }
  return pairs;
}

std::vector<size_t> Range(size_t from, size_t to) {
  std::vector<size_t> range;
  for (size_t i = from; i < to; ++i) {
    range.push_back(i);
  }
  return range;
}

TEST(FrameGroups, AreOneIfAllAgree) {
  EXPECT_EQ(GroupFrames(20, RowOf(20, [](size_t, size_t) { return true; })), Groups{Range(0, 20)});
}

TEST(FrameGroups, AreSingleFramesIfNoneAgreeOrNoneAreNear) {
  const Groups single = {{0}, {1}, {2}};
  EXPECT_EQ(GroupFrames(3, RowOf(3, [](size_t, size_t) { return false; })), single);
  EXPECT_EQ(GroupFrames(3, {}), single);
  EXPECT_EQ(GroupFrames(0, {}), Groups());
}

// Most pairs of the two halves agree: all that are more than 12 m apart.
TEST(FrameGroups, AreSplitWhereNearFramesDisagreeWhateverFarOnesSay) {
  const auto agree = [](size_t a, size_t b) { return (a < 10) == (b < 10) || b - a > 4; };
  EXPECT_EQ(GroupFrames(20, RowOf(20, agree)), (Groups{Range(0, 10), Range(10, 20)}));
}

TEST(FrameGroups, AreNotSplitByOnePair) {
  const auto agree = [](size_t a, size_t b) { return !(a == 9 && b == 10); };
  EXPECT_EQ(GroupFrames(20, RowOf(20, agree)), Groups{Range(0, 20)});
}

// As where a run of wrong answers interrupts right ones.
TEST(FrameGroups, AreJoinedAcrossFramesThatDisagree) {
  const auto is_wrong = [](size_t i) { return i >= 8 && i < 12; };
  const auto agree = [&](size_t a, size_t b) { return is_wrong(a) == is_wrong(b); };
  std::vector<size_t> right = Range(0, 8);
  for (const size_t i : Range(12, 20)) {
    right.push_back(i);
  }
  EXPECT_EQ(GroupFrames(20, RowOf(20, agree)), (Groups{right, Range(8, 12)}));
}

// A frame halfway between two groups agrees with both.
TEST(FrameGroups, AreNotJoinedByAFrameBetweenThem) {
  const auto agree = [](size_t a, size_t b) { return a == 10 || b == 10 || (a < 10) == (b < 10); };
  EXPECT_EQ(GroupFrames(21, RowOf(21, agree)).size(), 2u);
}

// The seam of distant groups is wider: 60 m where the shortest pair has 40 m.
TEST(FrameGroups, HaveASeamOfHalfTheirDistance) {
  const std::vector<FramePair> pairs = {{0, 1, 15.0, true}, {2, 3, 15.0, true}, {1, 2, 40.0, false},
                                        {0, 2, 55.0, true}, {1, 3, 55.0, true}, {0, 3, 58.0, true}};
  EXPECT_EQ(GroupFrames(4, pairs), Groups{Range(0, 4)});
}

TEST(FrameGroups, AreNotJoinedByATie) {
  EXPECT_EQ(GroupFrames(3, {{0, 1, 1.0, true}, {1, 2, 3.0, true}, {0, 2, 4.0, false}}),
            (Groups{{0, 1}, {2}}));
}

TEST(FrameGroups, AreAskedAgainWhenTheyHaveGrown) {
  EXPECT_EQ(GroupFrames(4, {{0, 1, 3.0, false},
                            {1, 2, 4.0, true},
                            {0, 2, 5.0, true},
                            {2, 3, 5.5, true},
                            {0, 3, 7.0, true}}),
            Groups{Range(0, 4)});
}

// When frame 1 joins the last four, all pairs of frame 0 have been visited.
TEST(FrameGroups, AreAskedAgainInAnotherRound) {
  EXPECT_EQ(GroupFrames(6, {{2, 3, 1.0, true},
                            {2, 4, 1.0, true},
                            {2, 5, 1.0, true},
                            {0, 1, 3.0, false},
                            {0, 2, 5.0, true},
                            {0, 4, 5.2, true},
                            {0, 3, 14.0, false},
                            {0, 5, 14.5, false},
                            {1, 2, 20.0, true}}),
            Groups{Range(0, 6)});
}

TEST(FrameGroups, DoNotDependOnTheOrderOfPairs) {
  const auto agree = [](size_t a, size_t b) { return (a * 7 + b * 5) % 4 != 0; };
  std::vector<FramePair> pairs = RowOf(20, agree);
  const Groups groups = GroupFrames(20, pairs);
  std::reverse(pairs.begin(), pairs.end());
  EXPECT_EQ(GroupFrames(20, pairs), groups);
}

}  // namespace
}  // namespace cairn
