#include "ingest/place/fit_placement.h"

#include <gtest/gtest.h>

#include <random>

namespace cairn {
namespace {

// Cameras along a straight street of 60 m; the map has them moved by `motion` about the middle and
// scaled by `scale`, with noise.
std::vector<PosePair> PosesOfStreet(const Rigid3d& motion, double scale, int num_outliers) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const Eigen::Vector3d middle(4.2e6, 6.3e5, 4.7e6);
  std::vector<PosePair> pairs;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d along(2.0 * i - 29.0, 0.1 * normal(random), 0.1 * normal(random));
    const Rigid3d ecef_from_cam(ExpSo3(Eigen::Vector3d(0.1, 0.2, 0.3)), middle + along);
    Rigid3d in_map(motion.rotation * ecef_from_cam.rotation,
                   middle + scale * (motion.rotation * along) + motion.translation);
    in_map.translation += 0.02 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    if (i < num_outliers) {
      in_map.translation += Eigen::Vector3d(20.0 + i, -30.0, 5.0);
    }
    pairs.push_back({ecef_from_cam.Inverse(), in_map.Inverse()});
  }
  return pairs;
}

TEST(FitPlacement, FindsTheMotionDespiteOutliers) {
  const Rigid3d motion(ExpSo3(Eigen::Vector3d(0.0, 0.0, 0.02)), Eigen::Vector3d(1.0, -0.5, 0.2));
  const PlacementFit fit = FitPlacement(PosesOfStreet(motion, 1.0, 9), {});
  EXPECT_EQ(fit.num_agreeing, 21);
  EXPECT_NEAR(fit.moved_m, motion.translation.norm(), 0.1);
  EXPECT_NEAR(fit.turned_rad, 0.02, 0.003);
  EXPECT_NEAR(fit.scale, 1.0, 0.005);
  EXPECT_LT(fit.median_residual_m, 0.1);
}

TEST(FitPlacement, SeesAWrongSize) {
  const PlacementFit fit = FitPlacement(PosesOfStreet(Rigid3d(), 0.9, 0), {});
  EXPECT_NEAR(fit.scale, 0.9, 0.01);
}

TEST(FitPlacement, FindsAStreetThatIsTurnedAroundAndFarAway) {
  const Rigid3d motion(ExpSo3(Eigen::Vector3d(0.5, -0.3, 2.9)), Eigen::Vector3d(30.0, -20.0, 9.0));
  const PlacementFit fit = FitPlacement(PosesOfStreet(motion, 1.0, 9), {});
  EXPECT_EQ(fit.num_agreeing, 21);
  EXPECT_NEAR(fit.moved_m, motion.translation.norm(), 0.1);
  EXPECT_NEAR(fit.turned_rad, Eigen::Vector3d(0.5, -0.3, 2.9).norm(), 0.003);
  EXPECT_LT(fit.median_residual_m, 0.1);
}

TEST(FitPlacement, SplitsTheMotionIntoLevelAndUp) {
  const Eigen::Vector3d middle(4.2e6, 6.3e5, 4.7e6);
  const Eigen::Vector3d up = middle.normalized();  // Within 0.2 degrees.
  const PlacementFit fit =
      FitPlacement(PosesOfStreet({ExpSo3(Eigen::Vector3d::Zero()), -12.0 * up}, 1.0, 0), {});
  EXPECT_NEAR(fit.moved_m, 12.0, 0.05);
  EXPECT_NEAR(fit.raised_m, -12.0, 0.05);
}

TEST(FitPlacement, CountsNoAgreementWhereThereIsNone) {
  std::vector<PosePair> pairs = PosesOfStreet(Rigid3d(), 1.0, 0);
  for (size_t i = 0; i < pairs.size(); ++i) {
    Rigid3d in_map = pairs[i].cam_from_ecef_in_map.Inverse();
    in_map.translation += Eigen::Vector3d(7.0 * (i % 5), 11.0 * (i % 3), 0.0);
    pairs[i].cam_from_ecef_in_map = in_map.Inverse();
  }
  EXPECT_LT(FitPlacement(pairs, {}).num_agreeing, 15);
}

}  // namespace
}  // namespace cairn
