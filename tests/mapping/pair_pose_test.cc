// A two view counts with the errors that its keypoints show.
#include "mapping/matching/pair_pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "core/angles.h"

namespace cairn {
namespace {

constexpr double kStatedRad = 2e-3;
constexpr double kRealRad = 3e-4;
constexpr int kNumRight = 150;

// A wall 8 m ahead, seen by a narrow camera, and one 2 m beside it.
Rigid3d AlongTheWall() { return {ExpSo3({0.0, -0.05, 0.0}), Eigen::Vector3d(-2.0, 0.0, 0.1)}; }

// After kNumRight right matches, `num_wrong` whose ends lie up to 8 mrad off in b.
PairRays MatchesOfAWall(int num_wrong) {
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::normal_distribution<double> noise(0.0, kRealRad);
  const auto moved = [](const Eigen::Vector3d& ray, auto&& error) {
    return Eigen::Vector3d((ray.normalized() + Eigen::Vector3d(error(), error(), 0)).normalized());
  };
  PairRays rays;
  for (int i = 0; i < kNumRight + num_wrong; ++i) {
    const Eigen::Vector3d x(1.0 + 1.2 * unit(rng), 1.5 * unit(rng), 8.0);
    const bool is_right = i < kNumRight;
    const Eigen::Vector3d a = moved(x, [&] { return noise(rng); });
    const Eigen::Vector3d b =
        moved(AlongTheWall() * x, [&] { return is_right ? noise(rng) : 4e-3 + 4e-3 * unit(rng); });
    rays.rays.push_back({a, b, EvenSpread(a, kStatedRad), EvenSpread(b, kStatedRad)});
    rays.match_of_ray.push_back(i);
  }
  return rays;
}

PairPose Found(const PairRays& rays) {
  Rigid3d pose = AlongTheWall();
  pose.translation.normalize();
  std::vector<int> all(rays.rays.size());
  std::iota(all.begin(), all.end(), 0);
  return {*RefineRelativePose(rays.rays, all, pose), all, 0.0};
}

double TurnedRad(const Rigid3d& b_from_a) {
  return RotationAngleRad(b_from_a.rotation, AlongTheWall().rotation);
}

TEST(NoiseOf, ComparesErrorsWithThoseStated) {
  const PairRays rays = MatchesOfAWall(0);
  const PairPose found = Found(rays);
  EXPECT_NEAR(NoiseOf(WithNoise(rays.rays, 0.25), found.inliers, found.pose.b_from_a),
              4.0 * kRealRad / kStatedRad, 0.1);
  EXPECT_EQ(NoiseOf(rays.rays, found.inliers, found.pose.b_from_a), kLeastNoise);
  EXPECT_EQ(NoiseOf(WithNoise(rays.rays, 0.01), found.inliers, found.pose.b_from_a), 1.0);
}

// A turn by 14 degrees more than the camera's moves the wall by no more than keypoints may err that
// are as rough as stated.
TEST(MakeTwoView, ExactKeypointsTellAShortWalkFromATurn) {
  const PairRays rays = MatchesOfAWall(0);
  const PairPose found = Found(rays);
  const std::vector<FeatureMatch> matches(rays.rays.size());
  EXPECT_EQ(FitRotation(rays.rays, found.inliers, found.pose.b_from_a.rotation).num_explained,
            kNumRight);
  EXPECT_EQ(MakeTwoView(rays, found, matches).kind, TwoViewKind::kGeneral);
}

// The stated focal length is 6 % too long, so rays fit a rotation less well than keypoints are
// exact.
TEST(MakeTwoView, ATurnUnderAFocalLengthThatIsOffStaysATurn) {
  std::mt19937_64 rng(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::normal_distribution<double> noise(0.0, kRealRad);
  const Eigen::Quaterniond turn = ExpSo3({0.0, 0.25, 0.0});
  PairRays rays;
  for (int i = 0; i < kNumRight; ++i) {
    const Eigen::Vector3d x(-0.15 + 0.3 * unit(rng), 0.35 * unit(rng), 1.0);
    const auto seen = [&](const Eigen::Vector3d& ray) {
      return Eigen::Vector3d(ray.x() / ray.z() / 1.06 + noise(rng),
                             ray.y() / ray.z() / 1.06 + noise(rng), 1.0)
          .normalized();
    };
    const Eigen::Vector3d a = seen(x), b = seen(turn * x);
    rays.rays.push_back({a, b, EvenSpread(a, kStatedRad), EvenSpread(b, kStatedRad)});
    rays.match_of_ray.push_back(i);
  }
  const auto found = FindPairPose(rays.rays, TwoViewOptions(), 0.0, 1);
  ASSERT_TRUE(found);
  const TwoView view = MakeTwoView(rays, *found, std::vector<FeatureMatch>(rays.rays.size()));
  EXPECT_EQ(view.kind, TwoViewKind::kRotationOnly);
}

TEST(MakeTwoView, MatchesThatAreWrongByLittleBendNothing) {
  const PairRays rays = MatchesOfAWall(20);
  const PairPose found = Found(rays);
  const TwoView view = MakeTwoView(rays, found, std::vector<FeatureMatch>(rays.rays.size()));
  EXPECT_LT(TurnedRad(view.b_from_a), 0.5 * TurnedRad(found.pose.b_from_a));
  EXPECT_LT(TurnedRad(view.b_from_a), 3.0 * view.rotation_sigma_rad);
}

}  // namespace
}  // namespace cairn
