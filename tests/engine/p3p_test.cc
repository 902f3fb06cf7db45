#include "engine/pose/p3p.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

#include "core/rigid3.h"

namespace cairn {
namespace {

using Eigen::Vector3d;

struct P3pProblem {
  Rigid3d cam_from_anchor;
  std::array<Vector3d, 3> bearings_in_cam;
  std::array<Vector3d, 3> x_in_anchor;
};

P3pProblem MakeP3pProblem(const Rigid3d& cam_from_anchor, const std::array<Vector3d, 3>& x_in_cam) {
  P3pProblem problem;
  problem.cam_from_anchor = cam_from_anchor;
  for (int i = 0; i < 3; ++i) {
    problem.bearings_in_cam[i] = x_in_cam[i].normalized();
    problem.x_in_anchor[i] = cam_from_anchor.Inverse() * x_in_cam[i];
  }
  return problem;
}

// Landmarks in front of the camera, within 45 degrees of its axis.
P3pProblem RandomP3pProblem(std::mt19937_64* random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto vector = [&](double scale) -> Vector3d {
    return scale * Vector3d(uniform(*random), uniform(*random), uniform(*random));
  };
  std::array<Vector3d, 3> x_in_cam;
  for (Vector3d& x : x_in_cam) {
    const double depth = 20.0 + 16.0 * uniform(*random);
    x = {depth * uniform(*random), depth * uniform(*random), depth};
  }
  return MakeP3pProblem(Rigid3d(ExpSo3(vector(2.0)), vector(30.0)), x_in_cam);
}

using Solutions = std::array<Eigen::Matrix<double, 3, 4>, 4>;

double BestError(const P3pProblem& problem, const Solutions& solutions, int num_solutions) {
  double best = 1e9;
  for (int i = 0; i < num_solutions; ++i) {
    best = std::min(best, (solutions[i] - problem.cam_from_anchor.ToMatrix()).norm());
  }
  return best;
}

double BearingError(const P3pProblem& problem, const Eigen::Matrix<double, 3, 4>& cam_from_anchor) {
  double worst = 0.0;
  for (int i = 0; i < 3; ++i) {
    const Vector3d x_in_cam = cam_from_anchor * problem.x_in_anchor[i].homogeneous();
    worst = std::max(worst, (x_in_cam.normalized() - problem.bearings_in_cam[i]).norm());
  }
  return worst;
}

TEST(SolveP3p, RecoversTruthAndOnlyExactPoses) {
  std::mt19937_64 random(1);
  int num_missed = 0;
  for (int i = 0; i < 5000; ++i) {
    const P3pProblem problem = RandomP3pProblem(&random);
    Solutions solutions;
    const int num_solutions = SolveP3p(problem.bearings_in_cam, problem.x_in_anchor, &solutions);
    num_missed += BestError(problem, solutions, num_solutions) > 1e-4;
    for (int k = 0; k < num_solutions; ++k) {
      const Eigen::Matrix3d rotation = solutions[k].leftCols<3>();
      EXPECT_LT((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
      EXPECT_GT(rotation.determinant(), 0.0);
      EXPECT_LT(BearingError(problem, solutions[k]), 1e-6);
    }
  }
  EXPECT_LE(num_missed, 2);  // Triples next to a degenerate configuration.
}

TEST(SolveP3p, SolutionsAreDistinct) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 500; ++i) {
    const P3pProblem problem = RandomP3pProblem(&random);
    Solutions solutions;
    const int num_solutions = SolveP3p(problem.bearings_in_cam, problem.x_in_anchor, &solutions);
    for (int a = 0; a < num_solutions; ++a) {
      for (int b = 0; b < a; ++b) {
        EXPECT_GT((solutions[a] - solutions[b]).norm(), 1e-7);
      }
    }
  }
}

TEST(SolveP3p, EquilateralTriangleSeenFromItsAxisHasFourSolutions) {
  // The classic example of Fischler and Bolles (1981).
  const double side = 2.0 * std::sqrt(3.0), axis = 4.0;
  std::array<Vector3d, 3> x_in_cam;
  for (int i = 0; i < 3; ++i) {
    const double angle = 2.0 * std::acos(-1.0) * i / 3.0;
    const double radius = side / std::sqrt(3.0);
    x_in_cam[i] = {radius * std::cos(angle), radius * std::sin(angle), axis};
  }
  const P3pProblem problem =
      MakeP3pProblem(Rigid3d(ExpSo3({0.3, -0.2, 0.5}), Vector3d(1, 2, 3)), x_in_cam);
  Solutions solutions;
  const int num_solutions = SolveP3p(problem.bearings_in_cam, problem.x_in_anchor, &solutions);
  EXPECT_EQ(num_solutions, 4);
  EXPECT_LT(BestError(problem, solutions, num_solutions), 1e-6);
}

TEST(SolveP3p, NoSolutionForDegenerateInput) {
  const Rigid3d cam_from_anchor(ExpSo3({0.1, 0.2, 0.3}), Vector3d(1, 0, 2));
  Solutions solutions;
  const auto solve = [&](const P3pProblem& problem) {
    return SolveP3p(problem.bearings_in_cam, problem.x_in_anchor, &solutions);
  };
  // Collinear landmarks.
  EXPECT_EQ(solve(MakeP3pProblem(cam_from_anchor,
                                 {Vector3d(0, 0, 5), Vector3d(1, 0, 6), Vector3d(2, 0, 7)})),
            0);
  // Two landmarks coincide.
  EXPECT_EQ(solve(MakeP3pProblem(cam_from_anchor,
                                 {Vector3d(0, 0, 5), Vector3d(0, 0, 5), Vector3d(2, 1, 7)})),
            0);
  // Two bearings are equal.
  P3pProblem equal =
      MakeP3pProblem(cam_from_anchor, {Vector3d(0, 0, 5), Vector3d(1, 2, 6), Vector3d(2, 1, 7)});
  equal.bearings_in_cam[1] = equal.bearings_in_cam[0];
  EXPECT_EQ(solve(equal), 0);
  // Not a number.
  P3pProblem invalid =
      MakeP3pProblem(cam_from_anchor, {Vector3d(0, 0, 5), Vector3d(1, 2, 6), Vector3d(2, 1, 7)});
  invalid.x_in_anchor[2].y() = std::nan("");
  EXPECT_EQ(solve(invalid), 0);
}

TEST(SolveP3p, MirroredSceneHasNoLandmarkBehindTheCamera) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 500; ++i) {
    P3pProblem problem = RandomP3pProblem(&random);
    for (Vector3d& bearing : problem.bearings_in_cam) {
      bearing = -bearing;
    }
    Solutions solutions;
    const int num_solutions = SolveP3p(problem.bearings_in_cam, problem.x_in_anchor, &solutions);
    for (int k = 0; k < num_solutions; ++k) {
      EXPECT_LT(BearingError(problem, solutions[k]), 1e-6);
    }
  }
}

TEST(SolveP3p, NoiseMovesSolutionLittle) {
  const P3pProblem problem =
      MakeP3pProblem(Rigid3d(ExpSo3({0.4, -0.1, 0.2}), Vector3d(5, 1, -3)),
                     {Vector3d(-4, -3, 12), Vector3d(5, -2, 9), Vector3d(1, 4, 14)});
  P3pProblem noisy = problem;
  for (int i = 0; i < 3; ++i) {
    noisy.bearings_in_cam[i][i] += 1e-4;
    noisy.bearings_in_cam[i].normalize();
  }
  Solutions solutions;
  const int num_solutions = SolveP3p(noisy.bearings_in_cam, noisy.x_in_anchor, &solutions);
  EXPECT_LT(BestError(problem, solutions, num_solutions), 0.05);
}

}  // namespace
}  // namespace cairn
