#include "engine/pose/normal_equations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace cairn {
namespace {

struct Reprojection {
  Eigen::Matrix<double, 2, 3> pixel_by_anchor;
  Eigen::Vector3d from_center;
  Eigen::Vector2d residual_px;
  double landmark_px_m = 0.0;
};

std::vector<Reprojection> RandomReprojections(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto draw = [&] { return uniform(random); };
  std::vector<Reprojection> reprojections(count);
  for (Reprojection& reprojection : reprojections) {
    reprojection.pixel_by_anchor =
        Eigen::Matrix<double, 2, 3>::NullaryExpr([&] { return 100.0 * draw(); });
    reprojection.from_center = Eigen::Vector3d::NullaryExpr([&] { return 30.0 * draw(); });
    reprojection.residual_px = Eigen::Vector2d::NullaryExpr([&] { return 9.0 * draw(); });
    reprojection.landmark_px_m = std::max(0.0, 60.0 * draw());
  }
  return reprojections;
}

void ExpectSumsOf(const std::vector<Reprojection>& reprojections) {
  const ResidualWeights weights = {.keypoint_sigma_px = 1.3, .cauchy_scale = 2.0};
  NormalEquations equations(weights);
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  PoseTangent gradient = PoseTangent::Zero();
  double cost = 0.0;
  for (const Reprojection& r : reprojections) {
    equations.Add(r.pixel_by_anchor, r.from_center, r.residual_px, r.landmark_px_m);
    const double landmark_px = r.landmark_px_m / r.from_center.norm();
    const double information = 1.0 / (1.3 * 1.3 + landmark_px * landmark_px);
    EXPECT_NEAR(ReprojectionInformation(weights, r.landmark_px_m, r.from_center.squaredNorm()),
                information, 1e-12);
    const double sq_residual = r.residual_px.squaredNorm() * information;
    const double weight = 1.0 / (1.0 + sq_residual / 4.0);
    EXPECT_NEAR(RobustWeight(weights, sq_residual), weight, 1e-12);
    const auto jacobian = ReprojectionJacobian(r.pixel_by_anchor, r.from_center);
    normal += weight * information * jacobian.transpose() * jacobian;
    gradient += weight * information * jacobian.transpose() * r.residual_px;
    cost += 0.5 * 4.0 * std::log1p(sq_residual / 4.0);
  }
  const NormalEquations::Sums sums = equations.Finish();
  EXPECT_LE((sums.normal - normal).norm(), 1e-12 * normal.norm());
  EXPECT_LE((sums.gradient - gradient).norm(), 1e-11 * gradient.norm());
  EXPECT_NEAR(sums.cost, cost, 1e-11 * cost);
}

// Whole batches and parts of one; more than the logarithm of one product is of.
TEST(NormalEquations, AreTheSumsOfAnyNumberOfReprojections) {
  for (const int count : {0, 1, 7, 8, 9, 64, 700}) {
    SCOPED_TRACE(count);
    ExpectSumsOf(RandomReprojections(count));
  }
}

TEST(NormalEquations, StayFiniteForResidualsFarOutsideTheImage) {
  NormalEquations equations(ResidualWeights{});
  std::vector<Reprojection> reprojections = RandomReprojections(500);
  for (const Reprojection& r : reprojections) {
    equations.Add(r.pixel_by_anchor, r.from_center, 1e15 * r.residual_px, r.landmark_px_m);
  }
  const NormalEquations::Sums sums = equations.Finish();
  EXPECT_TRUE(std::isfinite(sums.cost));
  EXPECT_TRUE(sums.normal.allFinite());
}

TEST(NormalEquations, ALandmarkInTheCenterOfTheCameraWeighsNothingButIsANumber) {
  const ResidualWeights weights;
  NormalEquations equations(weights);
  equations.Add(Eigen::Matrix<double, 2, 3>::Ones(), Eigen::Vector3d::Zero(), {1.0, 2.0}, 5.0);
  EXPECT_LT(equations.Finish().normal.norm(), 1e-6);
}

}  // namespace
}  // namespace cairn
