#include "ingest/place/placement_accuracy.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <vector>

#include "core/angles.h"
#include "core/radius68.h"

namespace cairn {
namespace {

// The walk of one simulated session: its true places, and where its positions say they are.
struct StatedWalk {
  std::vector<Eigen::Vector3d> truth, stated;
};

// A walk around a block with positions whose errors have three parts, as standard deviations per
// axis: common to all, common to each of six stretches, and of each position.
StatedWalk MakeStatedWalk(double common_m, double stretch_m, double own_m, uint64_t seed) {
  constexpr int kNumPositions = 60;
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&](double sigma_m) {
    const double x = normal(rng), y = normal(rng), z = normal(rng);
    return Eigen::Vector3d(sigma_m * Eigen::Vector3d(x, y, z));
  };
  const Eigen::Vector3d common = draw(common_m);
  Eigen::Vector3d of_stretch;
  StatedWalk walk;
  for (int i = 0; i < kNumPositions; ++i) {
    if (i % 10 == 0) {
      of_stretch = draw(stretch_m);
    }
    const double angle_rad = 2.0 * kPi * i / kNumPositions;
    walk.truth.emplace_back(60.0 * std::cos(angle_rad), 40.0 * std::sin(angle_rad), 0.2 * i);
    walk.stated.push_back(walk.truth.back() + common + of_stretch + draw(own_m));
  }
  return walk;
}

// The share of walks whose mean error, after the best similarity, is within the estimated radius.
struct Outcome {
  double share_within = 0.0;
  double mean_radius_m = 0.0;
  double share_turned_within = 0.0;
};

Outcome Try(double common_m, double stretch_m, double own_m, double stated_m) {
  constexpr int kNumWalks = 200;
  Outcome outcome;
  for (int seed = 0; seed < kNumWalks; ++seed) {
    const StatedWalk walk = MakeStatedWalk(common_m, stretch_m, own_m, seed);
    const auto num = static_cast<Eigen::Index>(walk.truth.size());
    Eigen::Matrix3Xd from(3, num), to(3, num);
    for (Eigen::Index i = 0; i < num; ++i) {
      from.col(i) = walk.truth[i];
      to.col(i) = walk.stated[i];
    }
    const Eigen::Matrix4d fit = Eigen::umeyama(from, to, true);
    std::vector<FittedPosition> positions;
    int num_near = 0;
    std::vector<double> errors_m;
    for (Eigen::Index i = 0; i < num; ++i) {
      const Eigen::Vector3d placed = (fit * from.col(i).homogeneous()).head<3>();
      positions.push_back({to.col(i), placed - to.col(i), stated_m});
      errors_m.push_back((placed - from.col(i)).norm());
    }
    const PlacementAccuracy accuracy = EstimatePlacementAccuracy(positions, 0.0);
    for (const double error_m : errors_m) {
      num_near += error_m <= accuracy.position_m;
    }
    outcome.share_within += static_cast<double>(num_near) / static_cast<double>(num) / kNumWalks;
    outcome.mean_radius_m += accuracy.position_m / kNumWalks;
    const Eigen::Matrix3d scaled = fit.topLeftCorner<3, 3>();
    const Eigen::Matrix3d rotation = scaled / std::cbrt(scaled.determinant());
    const double turned_rad = Eigen::AngleAxisd(rotation).angle();
    outcome.share_turned_within += (turned_rad <= accuracy.rotation_rad) / double{kNumWalks};
  }
  return outcome;
}

// The radius that a receiver states for these errors.
double Stated(double common_m, double stretch_m, double own_m) {
  return kRadius68PerSigma3d * std::hypot(common_m, stretch_m, own_m);
}

TEST(PlacementAccuracy, HoldsForNoise) {
  const Outcome outcome = Try(0.0, 0.0, 3.0, Stated(0.0, 0.0, 3.0));
  EXPECT_GT(outcome.share_within, 0.6);  // Noise may look like shared errors, not vice versa.
  EXPECT_LT(outcome.share_within, 0.9);
  EXPECT_NEAR(outcome.share_turned_within, 0.68, 0.15);
  EXPECT_LT(outcome.mean_radius_m, 2.2);  // Far below the 5.6 m of one position.
}

// The residuals show a thirtieth of the stated accuracy.
TEST(PlacementAccuracy, BelievesTheStatedAccuracyWhereTheResidualsShowLess) {
  const Outcome outcome = Try(3.0, 0.0, 0.1, Stated(3.0, 0.0, 0.1));
  EXPECT_NEAR(outcome.share_within, 0.68, 0.08);
  EXPECT_NEAR(outcome.mean_radius_m, kRadius68PerSigma3d * 3.0, 0.1);
}

// Errors that stretches share do not average out as noise does.
TEST(PlacementAccuracy, HoldsForErrorsOfStretches) {
  const Outcome outcome = Try(0.0, 3.0, 0.3, Stated(0.0, 3.0, 0.3));
  EXPECT_GT(outcome.share_within, 0.6);
  EXPECT_LT(outcome.share_within, 0.95);
  EXPECT_GT(outcome.mean_radius_m, 2.0 * Try(0.0, 0.0, 3.0, Stated(0.0, 0.0, 3.0)).mean_radius_m);
}

// A receiver that is worse than it says betrays itself.
TEST(PlacementAccuracy, BelievesTheResidualsWhereTheyAreLarger) {
  const Outcome outcome = Try(0.0, 0.0, 3.0, 0.1);
  EXPECT_GT(outcome.share_within, 0.6);
  EXPECT_LT(outcome.share_within, 0.9);
}

// The roll about a straight street is known from the cameras alone.
TEST(PlacementAccuracy, TakesTheRollAboutALineFromTheCameras) {
  std::vector<FittedPosition> positions;
  for (int i = 0; i < 30; ++i) {
    positions.push_back({{5.0 * i, 0, 0}, {0.0, i % 2 == 0 ? 1.0 : -1.0, 0.0}, 2.0});
  }
  const double with_cameras = EstimatePlacementAccuracy(positions, 0.1).rotation_rad;
  EXPECT_LT(with_cameras, 0.05);
  EXPECT_GT(EstimatePlacementAccuracy(positions, 0.0).rotation_rad, 1.0);
}

TEST(PlacementAccuracy, HoldsForFewPositions) {
  const std::vector<FittedPosition> positions = {{{0, 0, 0}, {0.1, 0, 0}, 5.0},
                                                 {{10, 0, 0}, {-0.1, 0.1, 0}, 5.0},
                                                 {{10, 10, 0}, {0, -0.1, 0}, 5.0}};
  const PlacementAccuracy accuracy = EstimatePlacementAccuracy(positions, 0.0);
  EXPECT_GE(accuracy.position_m, 4.9);
  EXPECT_LT(accuracy.position_m, 5.2);
  EXPECT_GT(accuracy.rotation_rad, 0.0);
}

}  // namespace
}  // namespace cairn
