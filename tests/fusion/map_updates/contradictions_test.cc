#include "fusion/map_updates/contradictions.h"

#include <gtest/gtest.h>

namespace cairn::fusion {
namespace {

constexpr int64_t kSecond = 1'000'000'000;
const Eigen::Vector3d kHere(1.0, 2.0, 0.0);

Rigid3d At(double east_m) {
  return Rigid3d(Eigen::Quaterniond::Identity(), Eigen::Vector3d(east_m, 0.0, 0.0));
}

AlignmentOptions FourOverThreeSeconds() {
  AlignmentOptions options;
  options.min_contradictions = 4;
  options.min_contradiction_span_s = 3.0;
  return options;
}

TEST(Contradictions, ManyThatAgreeAreReasonToGiveUp) {
  Contradictions contradictions(FourOverThreeSeconds());
  for (int64_t i = 0; i < 3; ++i) {
    EXPECT_FALSE(contradictions.Add(i * kSecond, At(30.0 + 0.1 * i), kHere)) << i;
  }
  EXPECT_TRUE(contradictions.Add(3 * kSecond, At(30.3), kHere));
  EXPECT_FALSE(contradictions.Add(4 * kSecond, At(30.3), kHere));  // Begins anew.
}

TEST(Contradictions, ManyAtOnceAreNot) {
  Contradictions contradictions(FourOverThreeSeconds());
  for (int64_t i = 0; i < 10; ++i) {
    EXPECT_FALSE(contradictions.Add(i * kSecond / 10, At(30.0), kHere)) << i;
  }
  EXPECT_TRUE(contradictions.Add(3 * kSecond, At(30.0), kHere));
}

TEST(Contradictions, OneThatDisagreesWithTheOthersBreaksTheRow) {
  Contradictions contradictions(FourOverThreeSeconds());
  for (int64_t i = 0; i < 3; ++i) {
    EXPECT_FALSE(contradictions.Add(i * kSecond, At(30.0), kHere));
  }
  EXPECT_FALSE(contradictions.Add(3 * kSecond, At(-50.0), kHere));
  for (int64_t i = 4; i < 7; ++i) {
    EXPECT_FALSE(contradictions.Add(i * kSecond, At(30.0), kHere)) << i;
  }
  EXPECT_TRUE(contradictions.Add(7 * kSecond, At(30.0), kHere));
}

TEST(Contradictions, AnAnswerThatAgreesWithTheStateClearsThem) {
  Contradictions contradictions(FourOverThreeSeconds());
  for (int64_t i = 0; i < 3; ++i) {
    contradictions.Add(i * kSecond, At(30.0), kHere);
  }
  contradictions.Clear();
  EXPECT_FALSE(contradictions.Add(3 * kSecond, At(30.0), kHere));
}

}  // namespace
}  // namespace cairn::fusion
