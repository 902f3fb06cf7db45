#include "fusion/map_updates/contradictions.h"

#include <gtest/gtest.h>

namespace cairn::fusion {
namespace {

constexpr int64_t kSecond = 1'000'000'000;
const Eigen::Vector3d kHere(1.0, 2.0, 0.0);

Rigid3d At(double east_m) {
  return Rigid3d(Eigen::Quaterniond::Identity(), Eigen::Vector3d(east_m, 0.0, 0.0));
}

// Answers before the one that makes kMinContradictions.
constexpr int64_t kTooFew = kMinContradictions - 1;
static_assert(kTooFew >= kMinContradictionSpanS, "an answer a second spans the time");

TEST(Contradictions, ManyThatAgreeAreReasonToGiveUp) {
  Contradictions contradictions;
  for (int64_t i = 0; i < kTooFew; ++i) {
    EXPECT_FALSE(contradictions.Add(i * kSecond, At(30.0 + 0.1 * i), kHere)) << i;
  }
  EXPECT_TRUE(contradictions.Add(kTooFew * kSecond, At(30.3), kHere));
  EXPECT_FALSE(contradictions.Add((kTooFew + 1) * kSecond, At(30.3), kHere));  // Begins anew.
}

TEST(Contradictions, ManyAtOnceAreNot) {
  Contradictions contradictions;
  for (int64_t i = 0; i < 10; ++i) {
    EXPECT_FALSE(contradictions.Add(i * kSecond / 10, At(30.0), kHere)) << i;
  }
  EXPECT_TRUE(contradictions.Add(3 * kSecond, At(30.0), kHere));
}

TEST(Contradictions, OneThatDisagreesWithTheOthersBreaksTheRow) {
  Contradictions contradictions;
  for (int64_t i = 0; i < kTooFew; ++i) {
    EXPECT_FALSE(contradictions.Add(i * kSecond, At(30.0), kHere));
  }
  EXPECT_FALSE(contradictions.Add(kTooFew * kSecond, At(-50.0), kHere));
  for (int64_t i = kTooFew + 1; i < 2 * kTooFew + 1; ++i) {
    EXPECT_FALSE(contradictions.Add(i * kSecond, At(30.0), kHere)) << i;
  }
  EXPECT_TRUE(contradictions.Add((2 * kTooFew + 1) * kSecond, At(30.0), kHere));
}

TEST(Contradictions, AnAnswerThatAgreesWithTheStateClearsThem) {
  Contradictions contradictions;
  for (int64_t i = 0; i < kTooFew; ++i) {
    contradictions.Add(i * kSecond, At(30.0), kHere);
  }
  contradictions.Clear();
  EXPECT_FALSE(contradictions.Add(kTooFew * kSecond, At(30.0), kHere));
}

}  // namespace
}  // namespace cairn::fusion
