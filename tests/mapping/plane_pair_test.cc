// The two stories that two photos of a plane allow.
#include "mapping/matching/plane_pair.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

#include "core/angles.h"

namespace cairn {
namespace {

// Matches of a wall 8 m ahead, to the right of the middle between the cameras. Every match whose
// index is a multiple of `others_every` lies in front of the wall; with 0, no match does.
std::vector<RayMatch> MatchesOfAWall(const Rigid3d& b_from_a, int others_every = 0,
                                     double noise_rad = 0.0) {
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<RayMatch> matches;
  for (int i = 0; i < 200; ++i) {
    const bool is_other = others_every > 0 && i % others_every == 0;
    const Eigen::Vector3d x(3.5 + 3.0 * unit(rng), 4.0 * unit(rng) - 2.0,
                            is_other ? 4.0 + 3.0 * unit(rng) : 8.0);
    const auto ray = [&](const Eigen::Vector3d& point) {
      const Eigen::Vector3d error(noise(rng), noise(rng), noise(rng));
      return Eigen::Vector3d((point.normalized() + noise_rad * error).normalized());
    };
    const Eigen::Vector3d a = ray(x), b = ray(b_from_a * x);
    matches.push_back({a, b, EvenSpread(a, 1e-3), EvenSpread(b, 1e-3)});
  }
  return matches;
}

std::vector<int> AllOf(const std::vector<RayMatch>& matches) {
  std::vector<int> all(matches.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

Eigen::Vector3d SumOfRays(const std::vector<RayMatch>& matches) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const RayMatch& match : matches) {
    sum += match.a;
  }
  return sum;
}

double AngleBetween(const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  return std::atan2(p.cross(q).norm(), p.dot(q));
}

// The second camera stands 4 m to the right.
Rigid3d AlongTheWall() { return {ExpSo3({0.02, -0.05, 0.01}), Eigen::Vector3d(-4.0, 0.1, 0.2)}; }

Rigid3d WithUnitBaseline(Rigid3d pose) {
  pose.translation.normalize();
  return pose;
}

TEST(FitPlane, FindsThePlaneAmongOtherPoints) {
  const Rigid3d truth = AlongTheWall();
  const std::vector<RayMatch> matches = MatchesOfAWall(truth, 10, 3e-4);
  const auto plane = FitPlane(matches, AllOf(matches), WithUnitBaseline(truth), 1);
  ASSERT_TRUE(plane);
  EXPECT_GE(plane->num_explained, 180);
  EXPECT_LT(plane->num_explained, 190);
  EXPECT_LT(AngleBetween(plane->normal_in_a, Eigen::Vector3d::UnitZ()), 0.02);
  EXPECT_NEAR(plane->normal_in_a.norm(), truth.translation.norm() / 8.0, 0.01);
}

TEST(TwinOf, GivesTheSamePicturesOfThePlane) {
  const Rigid3d truth = AlongTheWall();
  const std::vector<RayMatch> matches = MatchesOfAWall(truth);
  const Rigid3d pose = WithUnitBaseline(truth);
  const auto plane = FitPlane(matches, AllOf(matches), pose, 1);
  ASSERT_TRUE(plane);
  const auto twin = TwinOf(pose, *plane, SumOfRays(matches));
  ASSERT_TRUE(twin);
  // A turn by twice the angle under which the wall shows half of the baseline.
  EXPECT_NEAR(RotationAngleRad(twin->b_from_a.rotation, pose.rotation),
              2.0 * std::atan(0.5 * truth.translation.norm() / 8.0), 0.02);
  EXPECT_GT(AngleBetween(twin->normal_in_a, Eigen::Vector3d::UnitZ()), 1.0);
  int num_in_front = 0;
  for (const RayMatch& match : matches) {
    EXPECT_LT(SqEpipolarError(EssentialOf(twin->b_from_a), match), 1e-6);  // Variances.
    const auto depths = DepthsOf(twin->b_from_a, match);
    ASSERT_TRUE(depths);
    EXPECT_EQ(depths->first > 0.0, twin->normal_in_a.dot(match.a) > 0.0);
    EXPECT_EQ(depths->first > 0.0, depths->second > 0.0);
    num_in_front += depths->first > 0.0;
  }
  EXPECT_GE(num_in_front, 180);
}

TEST(TwinOf, OfTheTwinIsThePose) {
  const Rigid3d pose = WithUnitBaseline(AlongTheWall());
  const std::vector<RayMatch> matches = MatchesOfAWall(AlongTheWall());
  const std::vector<int> all = AllOf(matches);
  const Eigen::Vector3d middle = SumOfRays(matches);
  const auto twin = TwinOf(pose, *FitPlane(matches, all, pose, 1), middle);
  ASSERT_TRUE(twin);
  const auto back = TwinOf(twin->b_from_a, *FitPlane(matches, all, twin->b_from_a, 1), middle);
  ASSERT_TRUE(back);
  EXPECT_LT(RotationAngleRad(back->b_from_a.rotation, pose.rotation), 1e-6);
  EXPECT_LT(AngleBetween(back->b_from_a.translation, pose.translation), 1e-6);
}

TEST(TwinOf, IsNoneWithoutABaseline) {
  const SeenPlane far_away{Eigen::Vector3d(0.0, 0.0, 1e-4), 100};
  EXPECT_FALSE(TwinOf({Eigen::Quaterniond::Identity(), Eigen::Vector3d::UnitX()}, far_away,
                      Eigen::Vector3d::UnitZ()));
}

}  // namespace
}  // namespace cairn
