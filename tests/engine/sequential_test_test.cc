#include "engine/pose/sequential_test.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace cairn {
namespace {

constexpr int kStep = 64;

// Share of sequences of `size` draws that are rejected. A draw gains 0 but with probability
// `ratio`; then 1, or, with `is_fractional`, uniformly much in [0, 1] twice as often.
double RejectedShare(const SequentialTest& test, double mean_gain, int size, bool is_fractional) {
  constexpr int kNumSequences = 2000;
  constexpr int kMillion = 1'000'000;
  Random random(7);
  int num_rejected = 0;
  for (int i = 0; i < kNumSequences; ++i) {
    double sum = 0.0;
    for (int n = 1; n <= size; ++n) {
      const double probability = is_fractional ? 2.0 * mean_gain : mean_gain;
      if (random.Index(kMillion) < probability * kMillion) {
        sum += is_fractional ? static_cast<double>(random.Index(kMillion)) / kMillion : 1.0;
      }
      if (n % kStep == 0 && test.Rejects(n, sum)) {
        ++num_rejected;
        break;
      }
    }
  }
  return static_cast<double>(num_rejected) / kNumSequences;
}

TEST(SequentialTest, LosesNoMoreGoodPosesThanAllowed) {
  for (const double max_loss : {0.3, 0.05, 0.005}) {
    for (const bool is_fractional : {false, true}) {
      SequentialTest test(max_loss);
      test.SetGoodGain(0.05);
      EXPECT_LE(RejectedShare(test, 0.05, 4096, is_fractional), 1.1 * max_loss) << max_loss;
      EXPECT_GE(RejectedShare(test, 0.01, 4096, is_fractional), 0.99) << max_loss;
    }
  }
}

TEST(SequentialTest, RejectsNothingBeforeItKnowsAGoodPose) {
  const SequentialTest test(0.05);
  EXPECT_FALSE(test.Rejects(1e6, 0.0));
}

TEST(SequentialTest, RejectsNothingWhenGoodPosesAreNoBetterThanBadOnes) {
  SequentialTest test(0.05);
  test.SetGoodGain(0.005);  // Below the 0.01 of bad ones.
  EXPECT_FALSE(test.Rejects(1e6, 0.0));
  test.SetGoodGain(1.0);
  EXPECT_FALSE(test.Rejects(1e6, 0.0));
}

TEST(SequentialTest, LearnsWhatBadPosesGain) {
  SequentialTest test(0.05);
  test.SetGoodGain(0.1);
  for (int i = 0; i < 200; ++i) {
    test.LearnBadGain(0.05);
  }
  EXPECT_NEAR(test.bad_gain(), 0.05, 1e-5);
  // To a test that has learned it, a gain of 0.05 is that of a bad pose; to others, undecided.
  const SequentialTest fresh = [] {
    SequentialTest other(0.05);
    other.SetGoodGain(0.1);
    return other;
  }();
  EXPECT_TRUE(test.Rejects(300, 15));
  EXPECT_FALSE(fresh.Rejects(300, 15));
}

}  // namespace
}  // namespace cairn
