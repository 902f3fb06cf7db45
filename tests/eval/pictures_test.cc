#include "eval/pictures/pictures.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/images/gray_image.h"
#include "eval/pictures/encode_png.h"
#include "eval/pictures/plan_view.h"
#include "storage/map/map_store.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

GrayImage GrayPhoto() { return {320, 240, std::vector<uint8_t>(320 * 240, 100)}; }

LocalizeResult ResultWithOneInlier() {
  LocalizeResult result;
  result.localized = true;
  LocalizeMatch match;
  match.pixel = Eigen::Vector2d(100.5, 50.5);
  match.x_in_anchor = Eigen::Vector3d(0.0, 0.0, 12.0);
  result.matches = {match};
  return result;
}

TEST(DrawMatches, MarksInliersOnThePhoto) {
  const testing::TempDir dir;
  LocalizeQuery query;
  query.features.keypoints = {{200.0f, 200.0f, 2.0f, 0.0f}};
  query.features.descriptors.setZero(1, 128);
  DrawMatches(dir.File("matches.png"), GrayPhoto(), query, ResultWithOneInlier());
  const cv::Mat picture = cv::imread(dir.File("matches.png"));
  ASSERT_FALSE(picture.empty());
  EXPECT_GE(picture.cols, 960);
  // Somewhere there is color on the gray photo.
  int num_colored = 0;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < 900; ++x) {
      const auto& pixel = picture.at<cv::Vec3b>(y, x);
      num_colored += std::abs(pixel[0] - pixel[2]) > 60 ? 1 : 0;
    }
  }
  EXPECT_GT(num_colored, 20);
}

TEST(DrawMatches, DrawsAMiss) {
  const testing::TempDir dir;
  LocalizeResult miss;
  miss.reason = NotLocalizedReason::kNoCoverage;
  DrawMatches(dir.File("miss.png"), GrayPhoto(), LocalizeQuery(), miss);
  EXPECT_FALSE(cv::imread(dir.File("miss.png")).empty());
}

TEST(DrawMatches, SaysWhereItCannotWrite) {
  try {
    DrawMatches("/nowhere/picture.png", GrayPhoto(), LocalizeQuery(), ResultWithOneInlier());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kIo);
    EXPECT_NE(std::string(error.what()).find("/nowhere/picture.png"), std::string::npos);
  }
}

TEST(DrawTopView, DrawsPosesOnAnEmptyMap) {
  const testing::TempDir dir;
  const MapStore store = MapStore::Create(dir.File("map.gpkg"));
  TopViewPose pose;
  pose.label = "0";
  pose.prior = Geodetic::FromDegrees(47.0, 8.0, 400.0);
  pose.prior_accuracy_m = 15.0;
  pose.reference_cam_from_ecef = EcefFromEnu(*pose.prior).Inverse();
  DrawTopView(dir.File("view.png"), store, {pose});
  EXPECT_FALSE(cv::imread(dir.File("view.png")).empty());
}

TEST(DrawTopView, RefusesToDrawNothing) {
  const testing::TempDir dir;
  const MapStore store = MapStore::Create(dir.File("map.gpkg"));
  EXPECT_THROW(DrawTopView(dir.File("view.png"), store, {}), Error);
}

TEST(PlanView, IsNorthUpAndMetric) {
  const PlanView view({{-10.0, -5.0}, {30.0, 15.0}}, 400);
  EXPECT_NEAR(view.px_per_m(), 10.0, 1e-9);
  EXPECT_LT((view.PixelOf({-10.0, 15.0}) - Eigen::Vector2d(0.0, 0.0)).norm(), 1e-9);
  EXPECT_LT((view.PixelOf({30.0, -5.0}) - Eigen::Vector2d(400.0, 200.0)).norm(), 1e-9);
}

TEST(PlanView, WidensOblongAreas) {
  const PlanView view({{0.0, 0.0}, {100.0, 1.0}}, 500);
  EXPECT_TRUE(view.Contains({50.0, 20.0}));
  EXPECT_TRUE(view.Contains({50.0, -19.0}));
  EXPECT_FALSE(view.Contains({50.0, 30.0}));
}

TEST(EncodePng, IsLossless) {
  GrayImage photo = GrayPhoto();
  photo.pixels[77] = 201;
  const GrayImage decoded = DecodeGrayImage(EncodePng(photo));
  EXPECT_EQ(decoded.width_px, 320);
  EXPECT_EQ(decoded.pixels, photo.pixels);
}

TEST(EncodePng, RefusesAnEmptyImage) { EXPECT_THROW(EncodePng(GrayImage()), Error); }

}  // namespace
}  // namespace cairn
