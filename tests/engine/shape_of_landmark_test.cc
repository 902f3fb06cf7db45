#include "engine/tiles/shape_of_landmark.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "storage/tile/tile.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const double kSigmaM = SigmaFromCode(SigmaCode(0.3));  // As the tile stores it.

// A tile of one landmark, which cameras at `centers` saw.
SearchableTile TileSeenFrom(const Vector3d& x_in_tile, const std::vector<Vector3d>& centers) {
  static const auto codebook = std::make_shared<const Codebook>(testing::RandomCodebook());
  testing::RandomTileOptions options;
  options.num_landmarks = 1;
  options.num_keyframes = 0;
  Tile tile = testing::RandomTile(options);
  tile.x_in_tile[0] = x_in_tile.cast<float>();
  tile.sigma_codes[0] = SigmaCode(kSigmaM);
  for (const Vector3d& center : centers) {
    tile.keyframes.push_back(
        {KeyframeId(1), SessionId(1), Rigid3d(Matrix3d::Identity(), center).Inverse()});
    tile.keyframe_landmarks.push_back(0);
    tile.keyframe_begin.push_back(static_cast<uint32_t>(tile.keyframe_landmarks.size()));
  }
  return SearchableTile(std::move(tile), codebook, IndexOptions());
}

double SigmaAlong(const Matrix3d& covariance, const Vector3d& direction) {
  return std::sqrt(direction.normalized().dot(covariance * direction.normalized()));
}

TEST(ShapeOfLandmark, IsLongAlongTheRaysOfCamerasThatStandTogether) {
  const SearchableTile tile = TileSeenFrom({20, 0, 0}, {{0, -0.5, 0}, {0, 0.5, 0}});
  const LandmarkShape shape = ShapeOfLandmark(tile, 0);
  const Matrix3d& covariance = shape.covariance_sq_m;
  EXPECT_NEAR(covariance.trace(), 3.0 * kSigmaM * kSigmaM, 1e-6);
  // The rays meet at 0.05 rad, so that the distance is 40 times as uncertain as the direction.
  EXPECT_NEAR(SigmaAlong(covariance, {1, 0, 0}) / SigmaAlong(covariance, {0, 0, 1}), 40.0, 2.0);
  EXPECT_NEAR(SigmaAlong(covariance, {1, 0, 0}) / SigmaAlong(covariance, {0, 1, 0}), 40.0, 2.0);
  // Away from the cameras, by as much as the distance is uncertain.
  EXPECT_LT((shape.by_distance_m - Vector3d(SigmaAlong(covariance, {1, 0, 0}), 0, 0)).norm(), 1e-3);
}

TEST(ShapeOfLandmark, IsRoundForCamerasAllAroundWhichHaveNoDistanceInCommon) {
  const SearchableTile tile =
      TileSeenFrom({5, 5, 5}, {{9, 5, 5}, {1, 5, 5}, {5, 9, 5}, {5, 1, 5}, {5, 5, 9}, {5, 5, 1}});
  EXPECT_LT(
      (ShapeOfLandmark(tile, 0).covariance_sq_m - kSigmaM * kSigmaM * Matrix3d::Identity()).norm(),
      1e-6);
  EXPECT_EQ(ShapeOfLandmark(tile, 0).by_distance_m, Vector3d::Zero());
}

TEST(ShapeOfLandmark, IsRoundIfNoKeyframeOfTheTileSawTheLandmark) {
  EXPECT_LT((ShapeOfLandmark(TileSeenFrom({5, 5, 5}, {}), 0).covariance_sq_m -
             kSigmaM * kSigmaM * Matrix3d::Identity())
                .norm(),
            1e-6);
}

TEST(ShapeOfLandmark, OfOneViewOrAViewFromTheLandmarkItselfIsFinite) {
  for (const auto& centers :
       {std::vector<Vector3d>{{0, 0, 0}}, {{20, 0, 0}}, {{20, 0, 0}, {0, 0, 0}}}) {
    const Matrix3d covariance =
        ShapeOfLandmark(TileSeenFrom({20, 0, 0}, centers), 0).covariance_sq_m;
    ASSERT_TRUE(covariance.allFinite());
    EXPECT_NEAR(covariance.trace(), 3.0 * kSigmaM * kSigmaM, 1e-6);
    const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(covariance);
    EXPECT_GT(axes.eigenvalues()[0], 0.0);
  }
}

}  // namespace
}  // namespace cairn
