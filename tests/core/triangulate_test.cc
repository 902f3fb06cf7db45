#include "core/scene/triangulate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/reconstruction_builder.h"

namespace cairn {
namespace {

const Camera& TestCamera() {
  static const Camera camera(CameraModel::kOpenCv, 640, 480,
                             {400.0, 410.0, 320.0, 240.0, -0.1, 0.02, 1e-3, -1e-3});
  return camera;
}

const Eigen::Vector3d kPoint(20.0, 1.0, 3.0);

// Cameras along the y axis that look along +x at a point 20 m away.
std::vector<PointObservation> ObservationsAlongY(const std::vector<double>& offsets_m,
                                                 double noise_px = 0.0, uint64_t seed = 1) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<PointObservation> observations;
  for (const double y_m : offsets_m) {
    PointObservation observation;
    observation.camera = &TestCamera();
    observation.cam_from_world = testing::StreetWorld::LookAlong({0.0, y_m, 1.6}, 0.02 * y_m);
    observation.pixel = *TestCamera().Project(observation.cam_from_world * kPoint) +
                        noise_px * Eigen::Vector2d(noise(rng), noise(rng));
    observation.sigma_px = noise_px > 0.0 ? noise_px : 0.5;
    observations.push_back(observation);
  }
  return observations;
}

TEST(TriangulatePoint, RecoversThePointFromTwoViews) {
  const auto x_in_world = TriangulatePoint(ObservationsAlongY({-1.0, 1.0}));
  ASSERT_TRUE(x_in_world.has_value());
  EXPECT_LT((*x_in_world - kPoint).norm(), 1e-6);
}

TEST(TriangulatePoint, OneBadObservationAmongManyDoesNotMoveThePoint) {
  std::vector<PointObservation> observations = ObservationsAlongY({-3, -2, -1, 0, 1, 2, 3, 4}, 0.3);
  observations[2].pixel += Eigen::Vector2d(15.0, 5.0);
  const auto x_in_world = TriangulatePoint(observations);
  ASSERT_TRUE(x_in_world.has_value());
  EXPECT_LT((*x_in_world - kPoint).norm(), 0.3);
}

TEST(TriangulatePoint, RefusesOneViewAndParallelRays) {
  EXPECT_FALSE(TriangulatePoint(ObservationsAlongY({1.0})).has_value());
  EXPECT_FALSE(TriangulatePoint(ObservationsAlongY({1.0, 1.0})).has_value());
}

TEST(TriangulatePoint, RefusesAPointBehindTheCameras) {
  std::vector<PointObservation> observations = ObservationsAlongY({-1.0, 1.0});
  std::swap(observations[0].pixel, observations[1].pixel);  // Now the rays diverge.
  EXPECT_FALSE(TriangulatePoint(observations).has_value());
}

TEST(EstimateUncertainty, PredictsTheSpreadOfRepeatedTriangulations) {
  const std::vector<double> offsets_m = {-2.0, -1.0, 0.5, 2.0};
  const double noise_px = 0.5;
  const auto predicted = EstimateUncertainty(ObservationsAlongY(offsets_m, noise_px), kPoint);
  ASSERT_TRUE(predicted.has_value());
  double sum_sq_m = 0.0;
  constexpr int kNumTrials = 400;
  for (int i = 0; i < kNumTrials; ++i) {
    sum_sq_m += (*TriangulatePoint(ObservationsAlongY(offsets_m, noise_px, 100 + i)) - kPoint)
                    .squaredNorm();
  }
  const double measured_m = std::sqrt(sum_sq_m / (3.0 * kNumTrials));
  EXPECT_NEAR(predicted->Sigma() / measured_m, 1.0, 0.35);
}

TEST(EstimateUncertainty, GrowsWithDistanceOverBaseline) {
  const auto wide = EstimateUncertainty(ObservationsAlongY({-3.0, 3.0}), kPoint);
  const auto narrow = EstimateUncertainty(ObservationsAlongY({-0.03, 0.03}), kPoint);
  ASSERT_TRUE(wide && narrow);
  EXPECT_GT(narrow->Sigma(), 50.0 * wide->Sigma());
  // Mostly along the rays.
  EXPECT_GT(narrow->covariance(0, 0), 100.0 * narrow->covariance(2, 2));
}

TEST(EstimateUncertainty, GrowsWhenObservationsDisagree) {
  std::vector<PointObservation> observations = ObservationsAlongY({-2.0, -1.0, 1.0, 2.0});
  const double agreeing = EstimateUncertainty(observations, kPoint)->Sigma();
  observations[0].pixel.y() += 10.0;
  const auto disagreeing = EstimateUncertainty(observations, kPoint);
  EXPECT_GT(disagreeing->Sigma(), 3.0 * agreeing);
  EXPECT_NEAR(disagreeing->median_error_px, 0.0, 1e-6);
}

TEST(EstimateUncertainty, HasNoneForAPointOutOfSight) {
  EXPECT_FALSE(EstimateUncertainty(ObservationsAlongY({-1.0, 1.0}), -kPoint).has_value());
}

}  // namespace
}  // namespace cairn
