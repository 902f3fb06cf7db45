// Tests when rounds of keypoints end.
#include "engine/rounds.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace cairn {
namespace {

constexpr double kSure = 120.0;

struct FoundPose {
  double evidence = 0.0;
  double consensus = 0.0;
  double x_m = 0.0;
};

PoseHypotheses Found(const std::vector<FoundPose>& poses) {
  const auto matches = std::make_shared<const std::vector<Correspondence>>();
  PoseHypotheses hypotheses;
  hypotheses.TryInRounds(static_cast<int>(poses.size()), false, {}, [&](int i, double) {
    PoseEstimate estimate;
    estimate.evidence = poses[i].evidence;
    estimate.consensus = poses[i].consensus;
    estimate.cam_from_anchor.translation.x() = poses[i].x_m;
    return PoseAttempt{matches, estimate};
  });
  return hypotheses;
}

TEST(Rounds, TheFirstHasAnEighthButNotTooFew) {
  EXPECT_EQ(FirstRound(50), 50);
  EXPECT_EQ(FirstRound(1000), 128);
  EXPECT_EQ(FirstRound(8000), 1000);
}

TEST(Rounds, EvidenceAndEnoughKeypointsEndThem) {
  const AnswerOptions options;
  EXPECT_FALSE(IsBeyondDoubt({}, kSure, options));
  EXPECT_TRUE(IsBeyondDoubt(Found({{150.0, 50.0}}), kSure, options));
  EXPECT_FALSE(IsBeyondDoubt(Found({{110.0, 50.0}}), kSure, options));
  EXPECT_FALSE(IsBeyondDoubt(Found({{150.0, 20.0}}), kSure, options));
}

TEST(Rounds, TwoDozenKeypointsAreEnoughToSeeARival) {
  const AnswerOptions options;
  EXPECT_TRUE(IsBeyondDoubt(Found({{250.0, 24.5}}), kSure, options));
  EXPECT_FALSE(IsBeyondDoubt(Found({{250.0, 23.5}}), kSure, options));
  // A pose with enough evidence waits for its keypoints alone.
  EXPECT_LT(NextRound(128, 1000, Found({{250.0, 22.0}}), kSure), 200);
}

TEST(Rounds, ARivalWithAShareOfTheEvidenceLeavesDoubt) {
  const AnswerOptions options;
  EXPECT_FALSE(IsBeyondDoubt(Found({{200.0, 60.0}, {60.0, 20.0, 20.0}}), kSure, options));
  EXPECT_TRUE(IsBeyondDoubt(Found({{200.0, 60.0}, {40.0, 20.0, 20.0}}), kSure, options));
  EXPECT_TRUE(IsBeyondDoubt(Found({{200.0, 60.0}, {190.0, 60.0, 1.0}}), kSure, options));
}

TEST(Rounds, TheNextIsAsLargeAsThePoseNeeds) {
  // Half of the evidence needs a little more than twice the keypoints.
  const int next = NextRound(128, 1000, Found({{60.0, 40.0}}), kSure);
  EXPECT_GT(next, 256);
  EXPECT_LT(next, 400);
  // Enough evidence, but a rival.
  EXPECT_GT(NextRound(128, 1000, Found({{300.0, 90.0}}), kSure), 128);
  // A weak pose and no pose need all keypoints at once.
  EXPECT_EQ(NextRound(128, 1000, Found({{15.0, 10.0}}), kSure), 1000);
  EXPECT_EQ(NextRound(128, 1000, Found({{-5.0, 6.0}}), kSure), 1000);
  EXPECT_EQ(NextRound(128, 1000, {}, kSure), 1000);
}

}  // namespace
}  // namespace cairn
