#include "engine/voting/candidate_support.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace cairn {
namespace {

using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A ray of a camera at the origin with yaw 0 that looks straight at `x_in_anchor`.
VoteRay RayTo(int correspondence_idx, int keypoint_idx, const Vector3d& x_in_anchor) {
  VoteRay ray;
  ray.correspondence_idx = correspondence_idx;
  ray.keypoint_idx = keypoint_idx;
  ray.x_in_anchor = x_in_anchor;
  ray.direction_in_level = x_in_anchor.normalized();
  ray.horizontal = ray.direction_in_level.head<2>().norm();
  ray.view_azimuth = -x_in_anchor.head<2>().normalized();
  ray.min_distance_m = 0.3;
  ray.max_distance_m = 200.0;
  return ray;
}

PoseCandidate Support(const std::vector<VoteRay>& rays, const Vector3d& center_in_anchor,
                      double yaw_rad, const VotingOptions& options) {
  return SupportedCandidate(RayArrays<double>(rays, {1.0, -2.0, 3.0}), center_in_anchor, yaw_rad,
                            options);
}

TEST(SupportedCandidate, TruePoseHasFullScore) {
  const std::vector<VoteRay> rays = {RayTo(0, 0, {20, 3, 5}), RayTo(1, 1, {-10, 8, -1}),
                                     RayTo(2, 2, {5, -30, 12})};
  const PoseCandidate candidate = Support(rays, Vector3d::Zero(), 0.0, VotingOptions());
  EXPECT_NEAR(candidate.score, 3.0, 1e-9);
  EXPECT_THAT(candidate.correspondences, ElementsAre(0, 1, 2));
}

TEST(SupportedCandidate, KeypointCountsOnceButAllItsMatchesAreListed) {
  VoteRay second = RayTo(1, 0, {20, 3, 5});
  second.x_in_anchor.y() += 0.5;
  const PoseCandidate candidate =
      Support({RayTo(0, 0, {20, 3, 5}), second}, Vector3d::Zero(), 0.0, VotingOptions());
  EXPECT_NEAR(candidate.score, 1.0, 1e-9);
  EXPECT_THAT(candidate.correspondences, ElementsAre(0, 1));
}

TEST(SupportedCandidate, ScoreFallsWithTheSquareOfTheError) {
  VotingOptions options;
  options.direction_tolerance_rad = 0.05;
  options.cell_xy_m = 1.0;
  // 2 m of tolerance at 20 m; the landmark is off by 1 m.
  VoteRay ray = RayTo(0, 0, {20, 0, 0});
  ray.x_in_anchor = {20, 1, 0};
  const double distance_m = std::hypot(20.0, 1.0);
  const PoseCandidate candidate = Support({ray}, Vector3d::Zero(), 0.0, options);
  EXPECT_NEAR(candidate.score, 1.0 - std::pow(1.0 / (0.05 * distance_m + 1.0), 2), 1e-9);
  ray.x_in_anchor = {20, 3, 0};
  EXPECT_THAT(Support({ray}, Vector3d::Zero(), 0.0, options).correspondences, IsEmpty());
}

TEST(SupportedCandidate, In3dTheHeightDoesNotMatter) {
  const std::vector<VoteRay> rays = {RayTo(0, 0, {20, 3, 5}), RayTo(1, 1, {-10, 8, -1})};
  VotingOptions options;
  EXPECT_THAT(Support(rays, {0, 0, 30}, 0.0, options).correspondences, IsEmpty());
  options.filter = OutlierFilter::kVoting3d;
  const PoseCandidate candidate = Support(rays, {0, 0, 30}, 0.0, options);
  EXPECT_NEAR(candidate.score, 2.0, 1e-9);
  EXPECT_THAT(Support(rays, {0, 0, 30}, 0.3, options).correspondences, IsEmpty());
}

TEST(SupportedCandidate, RejectsBehindTooFarAndWrongAzimuth) {
  VoteRay behind = RayTo(0, 0, {20, 0, 0});
  behind.x_in_anchor = {-20, 0, 0};
  VoteRay far = RayTo(1, 1, {20, 0, 0});
  far.max_distance_m = 10.0;
  VoteRay near = RayTo(2, 2, {20, 0, 0});
  near.min_distance_m = 30.0;
  VoteRay seen_from_behind = RayTo(3, 3, {20, 0, 0});
  seen_from_behind.view_azimuth = {1, 0};
  const PoseCandidate candidate =
      Support({behind, far, near, seen_from_behind}, Vector3d::Zero(), 0.0, VotingOptions());
  EXPECT_EQ(candidate.score, 0.0);
  EXPECT_THAT(candidate.correspondences, IsEmpty());
}

TEST(SupportedCandidate, YawTurnsTheRays) {
  VoteRay ray = RayTo(0, 0, {20, 0, 0});
  ray.x_in_anchor = {0, 20, 0};
  ray.view_azimuth = {0, -1};
  EXPECT_NEAR(Support({ray}, Vector3d::Zero(), std::acos(-1.0) / 2, VotingOptions()).score, 1.0,
              1e-9);
}

TEST(SupportedCandidate, FurtherCamerasOfARigSeeFromTheirOwnPlace) {
  VoteRay ray = RayTo(0, 0, {20, 3, 5});
  ray.origin_in_level = {4, -5, 1};
  ray.x_in_anchor += ray.origin_in_level;
  EXPECT_NEAR(Support({ray}, Vector3d::Zero(), 0.0, VotingOptions()).score, 1.0, 1e-9);
  ray.origin_in_level.setZero();
  EXPECT_LT(Support({ray}, Vector3d::Zero(), 0.0, VotingOptions()).score, 0.5);
}

TEST(SupportedCandidate, ScoresTheBestMatchOfEachOfManyKeypoints) {
  VotingOptions options;
  std::vector<VoteRay> rays;
  double expected = 0.0;
  for (int keypoint = 0; keypoint < 40; ++keypoint) {  // More than one vector of them.
    const Vector3d landmark(20.0 + keypoint, 0.5 * keypoint - 10.0, 0.1 * keypoint);
    double best = 0.0;
    for (const double offset_m : {0.9, 0.3, 0.6}) {
      VoteRay ray = RayTo(static_cast<int>(rays.size()), keypoint, landmark);
      ray.x_in_anchor += offset_m * Vector3d(-landmark.y(), landmark.x(), 0.0).normalized();
      const double distance_m = ray.x_in_anchor.norm();
      const double sine = ray.direction_in_level.cross(ray.x_in_anchor).norm() / distance_m;
      const double tolerance = options.direction_tolerance_rad + options.cell_xy_m / distance_m;
      best = std::max(best, 1.0 - std::pow(sine / tolerance, 2));
      rays.push_back(ray);
    }
    expected += best;
  }
  const PoseCandidate candidate = Support(rays, Vector3d::Zero(), 0.0, options);
  EXPECT_EQ(candidate.correspondences.size(), rays.size());
  EXPECT_NEAR(candidate.score, expected, 1e-9);
}

// Landmarks all about the camera at the origin.
std::vector<VoteRay> RaysAllAround() {
  std::vector<VoteRay> rays;
  for (int i = 0; i < 12; ++i) {
    const double azimuth_rad = 0.52 * i, distance_m = 15.0 + 2.0 * i;
    rays.push_back(RayTo(i, i,
                         {distance_m * std::cos(azimuth_rad), distance_m * std::sin(azimuth_rad),
                          0.5 * (i % 5) - 1.0}));
  }
  return rays;
}

PoseCandidate Settled(const std::vector<VoteRay>& rays, const Vector3d& center_in_anchor,
                      double yaw_rad) {
  return SettledCandidate(RayArrays<double>(rays, {1.0, -2.0, 3.0}), center_in_anchor, yaw_rad,
                          VotingOptions());
}

TEST(SettledCandidate, FindsThePoseWithinACell) {
  const std::vector<VoteRay> rays = RaysAllAround();
  const Vector3d start(0.8, -0.7, 0.6);
  const PoseCandidate candidate = Settled(rays, start, 0.02);
  EXPECT_LT(candidate.center_in_anchor.norm(), 0.1 * start.norm());
  EXPECT_NEAR(candidate.yaw_rad, 0.0, 0.002);
  EXPECT_EQ(candidate.correspondences.size(), rays.size());
  EXPECT_GT(candidate.score, Support(rays, start, 0.02, VotingOptions()).score);
}

TEST(SettledCandidate, IsNotLedAstrayByWhatDoesNotAgree) {
  std::vector<VoteRay> rays = RaysAllAround();
  for (int i = 0; i < 12; ++i) {  // Landmarks that stand behind the camera.
    VoteRay wrong = RayTo(100 + i, 100 + i, rays[i].x_in_anchor);
    wrong.x_in_anchor = -wrong.x_in_anchor;
    rays.push_back(wrong);
  }
  const PoseCandidate candidate = Settled(rays, {0.8, -0.7, 0.6}, 0.02);
  EXPECT_LT(candidate.center_in_anchor.norm(), 0.15);
  EXPECT_EQ(candidate.correspondences.size(), 12u);
}

TEST(SettledCandidate, StaysWithinTheCellWhereRaysSayLittle) {
  // One ray: along it, nothing is known.
  const Vector3d start(0.5, 0.9, 0.0);
  const PoseCandidate candidate = Settled({RayTo(0, 0, {30, 0, 0})}, start, 0.0);
  EXPECT_NEAR(candidate.center_in_anchor.x(), start.x(), 0.2);
  EXPECT_LT(std::abs(candidate.center_in_anchor.y()), start.y());
  EXPECT_THAT(candidate.correspondences, ElementsAre(0));
}

TEST(SettledCandidate, CamerasOfARigTurnAboutTheFirst) {
  std::vector<VoteRay> rays = RaysAllAround();
  for (VoteRay& ray : rays) {
    ray.origin_in_level = {1.5, -0.5, 0.2};
    ray.x_in_anchor += ray.origin_in_level;
  }
  const PoseCandidate candidate = Settled(rays, {0.8, -0.7, 0.6}, 0.02);
  EXPECT_LT(candidate.center_in_anchor.norm(), 0.15);
  EXPECT_NEAR(candidate.yaw_rad, 0.0, 0.003);
}

TEST(SettledCandidate, OfNoAgreementIsWhereItWas) {
  const Vector3d start(0.5, 0.9, 0.1);
  const PoseCandidate candidate =
      Settled({RayTo(0, 0, {-30, 0, 0})}, start + Vector3d(-80, 0, 0), 0.0);
  EXPECT_EQ(candidate.score, 0.0);
  EXPECT_LT((candidate.center_in_anchor - start - Vector3d(-80, 0, 0)).norm(), 1e-9);
  EXPECT_THAT(candidate.correspondences, IsEmpty());
}

}  // namespace
}  // namespace cairn
