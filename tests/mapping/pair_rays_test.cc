#include "mapping/matching/pair_rays.h"

#include <gtest/gtest.h>

#include <random>

#include "core/scene/triangulate.h"

namespace cairn {
namespace {

constexpr int kWidthPx = 1200, kHeightPx = 900;
const Rigid3d kBFromA(ExpSo3(Eigen::Vector3d(0.02, -0.1, 0.01)),
                      Eigen::Vector3d(0.3, 0.1, 0.95).normalized());

struct NoisyPair {
  MappingPhoto a, b;
  std::vector<FeatureMatch> matches;
};

// Points that both cameras see beyond `least_radius_px` from the middle of a picture, with the
// errors that keypoints of their scale have.
NoisyPair SeeWithErrors(const Camera& camera, double least_radius_px) {
  constexpr int kNumPoints = 4000;
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<double> fraction(0.0, 1.0);
  std::normal_distribution<double> normal(0.0, 1.0);
  NoisyPair pair;
  const auto seen = [&](const Eigen::Vector2d& pixel) {
    Keypoint keypoint;
    keypoint.scale_px = 2.0f;
    const double sigma_px = KeypointSigmaPx(keypoint.scale_px);
    keypoint.x_px = static_cast<float>(pixel.x() + sigma_px * normal(rng));
    keypoint.y_px = static_cast<float>(pixel.y() + sigma_px * normal(rng));
    return keypoint;
  };
  while (pair.matches.size() < kNumPoints) {
    const Eigen::Vector2d in_a(kWidthPx * fraction(rng), kHeightPx * fraction(rng));
    const auto ray = camera.Unproject(in_a);
    const Eigen::Vector3d x_in_a = ray.value() * (5.0 + 20.0 * fraction(rng));
    const auto in_b = camera.Project(kBFromA * x_in_a);
    const Eigen::Vector2d middle(kWidthPx / 2.0, kHeightPx / 2.0);
    if (in_b && camera.Contains(*in_b) && (in_a - middle).norm() >= least_radius_px) {
      const int i = static_cast<int>(pair.matches.size());
      pair.a.keypoints.push_back(seen(in_a));
      pair.b.keypoints.push_back(seen(*in_b));
      pair.matches.push_back({.a_idx = i, .b_idx = i});
    }
  }
  return pair;
}

double MeanSqError(const Camera& camera, double least_radius_px) {
  const NoisyPair pair = SeeWithErrors(camera, least_radius_px);
  const PairRays rays = MakePairRays({pair.a, camera}, {pair.b, camera}, pair.matches);
  EXPECT_GT(rays.rays.size(), pair.matches.size() * 9 / 10);
  double sum = 0.0;
  for (const RayMatch& match : rays.rays) {
    sum += SqEpipolarError(EssentialOf(kBFromA), match);
  }
  return sum / static_cast<double>(rays.rays.size());
}

// Otherwise wide lenses would seem to fit better than long ones.
TEST(MakePairRays, ErrorsAreThoseOfKeypointsUnderAllLensesAndTowardTheEdges) {
  for (const double focal_px : {350.0, 700.0, 2400.0}) {
    const Camera camera(CameraModel::kSimpleRadial, kWidthPx, kHeightPx,
                        {focal_px, kWidthPx / 2.0, kHeightPx / 2.0, 0.02});
    EXPECT_NEAR(MeanSqError(camera, 0.0), 1.0, 0.1) << focal_px;
    EXPECT_NEAR(MeanSqError(camera, 550.0), 1.0, 0.1) << focal_px;
  }
  const Camera fisheye(CameraModel::kSimpleRadialFisheye, kWidthPx, kHeightPx,
                       {500.0, kWidthPx / 2.0, kHeightPx / 2.0, 0.01});
  EXPECT_NEAR(MeanSqError(fisheye, 0.0), 1.0, 0.1);
  EXPECT_NEAR(MeanSqError(fisheye, 550.0), 1.0, 0.1);
}

// A pixel at the edge of a wide picture is a smaller angle along the radius than across it.
TEST(RaySource, SpreadFollowsTheLens) {
  const Camera camera(CameraModel::kPinhole, kWidthPx, kHeightPx, {600, 600, 600, 450});
  MappingPhoto photo;
  photo.keypoints = {{.x_px = 1200.0f, .y_px = 450.0f, .scale_px = 1.0f}};
  const RaySource source{photo, camera};
  const auto ray = source.RayOf(0);
  ASSERT_TRUE(ray);
  const auto spread = source.SpreadOf(0, *ray);
  ASSERT_TRUE(spread);
  const double sigma = KeypointSigmaPx(1.0f) / 600.0;
  EXPECT_NEAR(spread->col(0).norm(), sigma * 0.5, 1e-9);             // cos(45 degrees) squared.
  EXPECT_NEAR(spread->col(1).norm(), sigma * std::sqrt(0.5), 1e-9);  // cos(45 degrees).
  EXPECT_NEAR(ray->dot(spread->col(0)), 0.0, 1e-12);
}

}  // namespace
}  // namespace cairn
