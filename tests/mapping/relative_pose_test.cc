#include "mapping/matching/relative_pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/random.h"
#include "engine/pose/ransac.h"

namespace cairn {
namespace {

constexpr double kSigmaRad = 1e-3;

Eigen::Vector3d RandomVector(Random* random) {
  return {random->Fraction() - 0.5, random->Fraction() - 0.5, random->Fraction() - 0.5};
}

Rigid3d Somewhere(Random* random) {
  return {ExpSo3(0.6 * RandomVector(random)), RandomVector(random).normalized()};
}

// Points 3 to 12 baselines in front of a.
std::vector<RayMatch> Matches(const Rigid3d& b_from_a, int num_right, int num_wrong, double noise,
                              Random* random) {
  std::vector<RayMatch> matches;
  for (int i = 0; i < num_right + num_wrong; ++i) {
    const Eigen::Vector3d x_in_a(4.0 * (random->Fraction() - 0.5), 4.0 * (random->Fraction() - 0.5),
                                 3.0 + 9.0 * random->Fraction());
    const Eigen::Vector3d x_in_b =
        i < num_right ? Eigen::Vector3d(b_from_a * x_in_a)
                      : Eigen::Vector3d(RandomVector(random) + Eigen::Vector3d(0, 0, 1));
    const Eigen::Vector3d a = (x_in_a.normalized() + noise * RandomVector(random)).normalized();
    const Eigen::Vector3d b = (x_in_b.normalized() + noise * RandomVector(random)).normalized();
    matches.push_back({a, b, EvenSpread(a, kSigmaRad), EvenSpread(b, kSigmaRad)});
  }
  return matches;
}

double DirectionError(const Rigid3d& p, const Rigid3d& q) {
  return std::acos(
      std::clamp(p.translation.normalized().dot(q.translation.normalized()), -1.0, 1.0));
}

TEST(SolveFivePoint, FindsTheEssentialMatrixOfExactRays) {
  Random random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Rigid3d b_from_a = Somewhere(&random);
    const auto matches = Matches(b_from_a, 5, 0, 0.0, &random);
    std::array<Eigen::Vector3d, 5> a, b;
    for (int i = 0; i < 5; ++i) {
      a[i] = matches[i].a;
      b[i] = matches[i].b;
    }
    std::array<Eigen::Matrix3d, kMaxEssentials> essentials;
    const int count = SolveFivePoint(a, b, &essentials);
    const Eigen::Matrix3d truth = EssentialOf(b_from_a).normalized();
    double best = 1.0;
    for (int i = 0; i < count; ++i) {
      best = std::min({best, (essentials[i] - truth).norm(), (essentials[i] + truth).norm()});
      for (int k = 0; k < 5; ++k) {
        EXPECT_NEAR(b[k].dot(essentials[i] * a[k]), 0.0, 1e-9);
      }
    }
    EXPECT_LT(best, 1e-6) << "trial " << trial;
  }
}

TEST(RelativePoseProblem, FindsThePoseAmongWrongMatches) {
  Random random(7);
  for (int trial = 0; trial < 5; ++trial) {
    const Rigid3d b_from_a = Somewhere(&random);
    const auto matches = Matches(b_from_a, 60, 60, kSigmaRad, &random);
    RelativePoseProblem problem(matches, 3);
    const auto result = LoRansac(&problem, RansacOptions{.max_iterations = 1000}, 3);
    ASSERT_TRUE(result.model);
    EXPECT_LT(RotationAngleRad(result.model->b_from_a.rotation, b_from_a.rotation), 0.01);
    EXPECT_LT(DirectionError(result.model->b_from_a, b_from_a), 0.03);
    const std::vector<int> inliers = problem.InliersOf(result.model->b_from_a);
    const auto num_right =
        std::count_if(inliers.begin(), inliers.end(), [](int i) { return i < 60; });
    EXPECT_GE(num_right, 55);
    EXPECT_LE(inliers.size() - num_right, 6u);
  }
}

TEST(RefineRelativePose, StatesErrorsThatHold) {
  Random random(9);
  double sum_rotation = 0.0, sum_direction = 0.0;
  constexpr int kTrials = 20;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Rigid3d b_from_a = Somewhere(&random);
    const auto matches = Matches(b_from_a, 100, 0, 2.0 * kSigmaRad, &random);
    std::vector<int> all(matches.size());
    std::iota(all.begin(), all.end(), 0);
    const Rigid3d start(ExpSo3(Eigen::Vector3d(0.01, -0.01, 0.01)) * b_from_a.rotation,
                        (b_from_a.translation + Eigen::Vector3d(0.05, 0.0, 0.05)).normalized());
    const auto refined = RefineRelativePose(matches, all, start);
    ASSERT_TRUE(refined);
    sum_rotation += RotationAngleRad(refined->b_from_a.rotation, b_from_a.rotation) /
                    refined->rotation_sigma_rad / kTrials;
    sum_direction +=
        DirectionError(refined->b_from_a, b_from_a) / refined->direction_sigma_rad / kTrials;
  }
  EXPECT_GT(sum_rotation, 0.2);
  EXPECT_LT(sum_rotation, 1.5);
  EXPECT_GT(sum_direction, 0.2);
  EXPECT_LT(sum_direction, 1.5);
}

TEST(FitRotation, ExplainsATurnButNotAWalk) {
  Random random(11);
  Rigid3d turn = Somewhere(&random);
  turn.translation.setZero();
  std::vector<int> all(80);
  std::iota(all.begin(), all.end(), 0);
  const auto turned = Matches(turn, 80, 0, kSigmaRad, &random);
  EXPECT_GE(FitRotation(turned, all, Eigen::Quaterniond::Identity()).num_explained, 78);
  const Rigid3d walk = Somewhere(&random);
  const auto walked = Matches(walk, 80, 0, kSigmaRad, &random);
  EXPECT_LE(FitRotation(walked, all, walk.rotation).num_explained, 40);
}

}  // namespace
}  // namespace cairn
