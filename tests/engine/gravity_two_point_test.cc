#include "engine/pose/gravity_two_point.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

namespace cairn {
namespace {

using Eigen::Vector3d;

struct TwoPointProblem {
  LevelPose truth;
  std::array<Vector3d, 2> bearings_in_level;
  std::array<Vector3d, 2> x_in_anchor;
};

Vector3d InLevel(const LevelPose& pose, const Vector3d& x_in_anchor) {
  const Vector3d offset = x_in_anchor - pose.center_in_anchor;
  const double c = pose.yaw_direction.x(), s = pose.yaw_direction.y();
  return {c * offset.x() + s * offset.y(), -s * offset.x() + c * offset.y(), offset.z()};
}

// The bearings under which a camera at `center` sees two landmarks.
TwoPointProblem MakeTwoPointProblem(double yaw_rad, const Vector3d& center, const Vector3d& x1,
                                    const Vector3d& x2) {
  TwoPointProblem problem;
  problem.truth = {{std::cos(yaw_rad), std::sin(yaw_rad)}, center};
  problem.x_in_anchor = {x1, x2};
  for (int i = 0; i < 2; ++i) {
    problem.bearings_in_level[i] = InLevel(problem.truth, problem.x_in_anchor[i]).normalized();
  }
  return problem;
}

TwoPointProblem RandomTwoPointProblem(std::mt19937_64* random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto point = [&](double scale) -> Vector3d {
    return scale * Vector3d(uniform(*random), uniform(*random), uniform(*random));
  };
  return MakeTwoPointProblem(3.1 * uniform(*random), point(10.0), point(50.0), point(50.0));
}

double PoseError(const LevelPose& a, const LevelPose& b) {
  return (a.center_in_anchor - b.center_in_anchor).norm() +
         (a.yaw_direction - b.yaw_direction).norm();
}

TEST(SolveGravityTwoPoint, RecoversTruthAndOnlyExactPoses) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    const TwoPointProblem problem = RandomTwoPointProblem(&random);
    std::array<LevelPose, 2> poses;
    const int num_poses =
        SolveGravityTwoPoint(problem.bearings_in_level, problem.x_in_anchor, &poses);
    ASSERT_GE(num_poses, 1);
    double best = 1e9;
    for (int k = 0; k < num_poses; ++k) {
      best = std::min(best, PoseError(poses[k], problem.truth));
      EXPECT_NEAR(poses[k].yaw_direction.norm(), 1.0, 1e-9);
      for (int j = 0; j < 2; ++j) {
        const Vector3d seen = InLevel(poses[k], problem.x_in_anchor[j]).normalized();
        EXPECT_LT((seen - problem.bearings_in_level[j]).norm(), 1e-6);
      }
    }
    EXPECT_LT(best, 1e-5) << i;
  }
}

TEST(SolveGravityTwoPoint, OneHorizontalRayIsEnoughOfTheOther) {
  const TwoPointProblem problem =
      MakeTwoPointProblem(0.7, {1, 2, 3}, {20, 5, 3} /* at camera height */, {15, -8, 7});
  for (const bool swapped : {false, true}) {
    std::array<Vector3d, 2> bearings = problem.bearings_in_level, points = problem.x_in_anchor;
    if (swapped) {
      std::swap(bearings[0], bearings[1]);
      std::swap(points[0], points[1]);
    }
    std::array<LevelPose, 2> poses;
    const int num_poses = SolveGravityTwoPoint(bearings, points, &poses);
    ASSERT_GE(num_poses, 1);
    EXPECT_LT(std::min(PoseError(poses[0], problem.truth),
                       num_poses == 2 ? PoseError(poses[1], problem.truth) : 1e9),
              1e-9);
  }
}

TEST(SolveGravityTwoPoint, NearlyHorizontalRaysStayAccurate) {
  const TwoPointProblem problem =
      MakeTwoPointProblem(-2.0, {0, 0, 0}, {40, 5, 0.02}, {35, -8, -0.03});
  std::array<LevelPose, 2> poses;
  const int num_poses =
      SolveGravityTwoPoint(problem.bearings_in_level, problem.x_in_anchor, &poses);
  ASSERT_GE(num_poses, 1);
  EXPECT_LT(std::min(PoseError(poses[0], problem.truth),
                     num_poses == 2 ? PoseError(poses[1], problem.truth) : 1e9),
            1e-8);
}

TEST(SolveGravityTwoPoint, RaysMayStartAtDifferentCamerasOfARig) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto vector = [&](double scale) -> Eigen::Vector3d {
    return scale * Eigen::Vector3d(uniform(random), uniform(random), uniform(random));
  };
  for (int i = 0; i < 100; ++i) {
    const Eigen::AngleAxisd anchor_from_level(3.0 * uniform(random), Eigen::Vector3d::UnitZ());
    const Eigen::Vector3d center = vector(50.0);
    std::array<Eigen::Vector3d, 2> origins, bearings, points;
    for (int k = 0; k < 2; ++k) {
      origins[k] = vector(2.0);
      bearings[k] = vector(1.0).normalized();
      points[k] =
          center + anchor_from_level * (origins[k] + (20.0 + 15.0 * uniform(random)) * bearings[k]);
    }
    std::array<LevelPose, 2> poses;
    const int num_poses = SolveGravityTwoPoint(bearings, points, &poses, origins);
    double best_error_m = 1e9;
    for (int k = 0; k < num_poses; ++k) {
      best_error_m = std::min(best_error_m, (poses[k].center_in_anchor - center).norm());
    }
    EXPECT_LT(best_error_m, 1e-6) << i;
  }
}

TEST(SolveGravityTwoPoint, NoSolutionForDegenerateInput) {
  std::array<LevelPose, 2> poses;
  const auto solve = [&](const TwoPointProblem& problem) {
    return SolveGravityTwoPoint(problem.bearings_in_level, problem.x_in_anchor, &poses);
  };
  // Both rays horizontal.
  EXPECT_EQ(solve(MakeTwoPointProblem(0.3, {0, 0, 2}, {20, 5, 2}, {15, -8, 2})), 0);
  // One landmark above the other.
  EXPECT_EQ(solve(MakeTwoPointProblem(0.3, {0, 0, 2}, {20, 5, 4}, {20, 5, 9})), 0);
  // The same landmark twice.
  EXPECT_EQ(solve(MakeTwoPointProblem(0.3, {0, 0, 2}, {20, 5, 4}, {20, 5, 4})), 0);
  // Equal bearings to different landmarks.
  TwoPointProblem equal = MakeTwoPointProblem(0.3, {0, 0, 2}, {20, 5, 4}, {12, -3, 9});
  equal.bearings_in_level[1] = equal.bearings_in_level[0];
  EXPECT_EQ(solve(equal), 0);
  // Not a number.
  TwoPointProblem invalid = MakeTwoPointProblem(0.3, {0, 0, 2}, {20, 5, 4}, {12, -3, 9});
  invalid.x_in_anchor[0].x() = std::nan("");
  EXPECT_EQ(solve(invalid), 0);
}

TEST(SolveGravityTwoPoint, MirroredSceneHasNoLandmarkBehindTheCamera) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 500; ++i) {
    TwoPointProblem problem = RandomTwoPointProblem(&random);
    for (Vector3d& bearing : problem.bearings_in_level) {
      bearing = -bearing;
    }
    std::array<LevelPose, 2> poses;
    const int num_poses =
        SolveGravityTwoPoint(problem.bearings_in_level, problem.x_in_anchor, &poses);
    for (int k = 0; k < num_poses; ++k) {
      for (int j = 0; j < 2; ++j) {
        EXPECT_GT(InLevel(poses[k], problem.x_in_anchor[j]).dot(problem.bearings_in_level[j]), 0.0);
      }
    }
  }
}

TEST(SolveGravityTwoPoint, NoiseMovesSolutionLittle) {
  const TwoPointProblem problem = MakeTwoPointProblem(0.9, {1, 2, 1.5}, {14, 9, 6}, {18, -6, 0.2});
  TwoPointProblem noisy = problem;
  noisy.bearings_in_level[0] =
      (noisy.bearings_in_level[0] + Vector3d(1, -1, 1) * 1e-3).normalized();
  noisy.bearings_in_level[1] =
      (noisy.bearings_in_level[1] + Vector3d(-1, 1, 1) * 1e-3).normalized();
  std::array<LevelPose, 2> poses;
  const int num_poses = SolveGravityTwoPoint(noisy.bearings_in_level, noisy.x_in_anchor, &poses);
  ASSERT_GE(num_poses, 1);
  EXPECT_LT(std::min(PoseError(poses[0], problem.truth),
                     num_poses == 2 ? PoseError(poses[1], problem.truth) : 1e9),
            0.5);
}

}  // namespace
}  // namespace cairn
