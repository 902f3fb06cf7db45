#include "lab/experiments/verdict.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/error.h"

namespace cairn {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(JudgeGreater, FallsWhereTheIntervalLies) {
  EXPECT_EQ(JudgeGreater({0.03, 0.01, 0.05}), Verdict::kHolds);
  EXPECT_EQ(JudgeGreater({-0.03, -0.05, -0.01}), Verdict::kDoesNotHold);
  EXPECT_EQ(JudgeGreater({0.03, -0.01, 0.05}), Verdict::kUndecided);
  EXPECT_EQ(JudgeGreater({0.6, 0.55, 0.65}, 0.5), Verdict::kHolds);
  EXPECT_EQ(JudgeGreater({0.6, 0.45, 0.65}, 0.5), Verdict::kUndecided);
}

TEST(JudgeGreater, ADifferenceOfExactlyNothingIsUndecided) {
  EXPECT_EQ(JudgeGreater({0.0, 0.0, 0.0}), Verdict::kUndecided);
}

TEST(JudgeGreater, WhatCannotBeMeasuredIsUndecided) {
  EXPECT_EQ(JudgeGreater({kNaN, kNaN, kNaN}), Verdict::kUndecided);
}

TEST(JudgeSmaller, FallsWhereTheIntervalLies) {
  EXPECT_EQ(JudgeSmaller({0.8, 0.7, 0.9}, 1.0), Verdict::kHolds);
  EXPECT_EQ(JudgeSmaller({1.2, 1.1, 1.3}, 1.0), Verdict::kDoesNotHold);
  EXPECT_EQ(JudgeSmaller({0.9, 0.7, 1.1}, 1.0), Verdict::kUndecided);
  EXPECT_EQ(JudgeSmaller({kNaN, kNaN, kNaN}, 1.0), Verdict::kUndecided);
}

TEST(JudgeEqual, NeedsTheWholeIntervalWithinTheMargin) {
  EXPECT_EQ(JudgeEqual({0.0, -0.01, 0.01}, 0.02), Verdict::kHolds);
  EXPECT_EQ(JudgeEqual({0.0, -0.03, 0.01}, 0.02), Verdict::kUndecided);
  EXPECT_EQ(JudgeEqual({0.05, 0.03, 0.07}, 0.02), Verdict::kDoesNotHold);
  EXPECT_EQ(JudgeEqual({-0.05, -0.07, -0.03}, 0.02), Verdict::kDoesNotHold);
  EXPECT_EQ(JudgeEqual({kNaN, kNaN, kNaN}, 0.02), Verdict::kUndecided);
}

TEST(JudgeEqual, ATinyButCertainDifferenceIsNone) {
  EXPECT_EQ(JudgeEqual({0.005, 0.004, 0.006}, 0.02), Verdict::kHolds);
}

TEST(JudgeAll, IsAsStrongAsItsWeakestPart) {
  const Verdict holds = Verdict::kHolds, fails = Verdict::kDoesNotHold, open = Verdict::kUndecided,
                missing = Verdict::kNotBuilt;
  EXPECT_EQ(JudgeAll({holds, holds}), holds);
  EXPECT_EQ(JudgeAll({holds, open}), open);
  EXPECT_EQ(JudgeAll({holds, open, fails}), fails);
  EXPECT_EQ(JudgeAll({fails, missing}), missing);
  EXPECT_EQ(JudgeAll({}), open);
}

TEST(VerdictName, RoundTrips) {
  for (const Verdict verdict :
       {Verdict::kHolds, Verdict::kDoesNotHold, Verdict::kUndecided, Verdict::kNotBuilt}) {
    EXPECT_EQ(VerdictFromName(VerdictName(verdict)), verdict);
  }
  EXPECT_THROW(VerdictFromName("perhaps"), Error);
}

TEST(DifferenceText, ShowsSigns) {
  EXPECT_EQ(DifferenceText({0.0312, -0.0119, 0.05}), "+0.031 [-0.012, +0.050]");
  EXPECT_EQ(IntervalText({0.5, 0.25, 0.75}, 2), "0.50 [0.25, 0.75]");
}

}  // namespace
}  // namespace cairn
