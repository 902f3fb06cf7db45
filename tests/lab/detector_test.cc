#include "lab/city/detector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "core/error.h"
#include "lab/city/camera_angles.h"

namespace cairn {
namespace {

const Camera kCamera(CameraModel::kPinhole, 800, 600, {500.0, 500.0, 400.0, 300.0});

CityOptions DenseOptions() {
  CityOptions options = CityPreset(CityCharacter::kOldTown);
  options.min_landmark_size_m = 0.02;
  return options;
}

class OldTown : public ::testing::Test {
 protected:
  OldTown()
      : city_(DenseOptions()),
        region_(city_, BoxAroundPoint(Eigen::Vector2d::Zero(), 120.0), 0.0),
        cam_from_site_(LookAlongAStreet()) {}

  // From the middle of a street, half to the side.
  Rigid3d LookAlongAStreet() const {
    const CityStreet street = city_.StreetsIn(BoxAroundPoint({0.0, 0.0}, 40.0)).front();
    const Eigen::Vector2d at = street.At(0.4 * street.LengthM(), 0.0);
    const Eigen::Vector2d way = street.Direction();
    return CamFromEnu({at.x(), at.y(), city_.GroundM(at) + 1.6},
                      {.yaw_rad = std::atan2(way.y(), way.x()) + 0.6, .pitch_rad = 0.1});
  }

  std::vector<Detection> Detect(const DetectorOptions& options, uint64_t image_id = 1) const {
    return DetectLandmarks(region_, kCamera, cam_from_site_, options, image_id, image_id);
  }

  static DetectorOptions Noiseless() {
    DetectorOptions options;
    options.max_keypoints = 20'000;
    options.position_noise = options.log_scale_sigma = options.orientation_sigma_rad = 0.0;
    options.other_orientation_share = options.crowd_share = 0.0;
    return options;
  }

  City city_;
  CityRegion region_;
  Rigid3d cam_from_site_;
};

TEST_F(OldTown, FindsOnlyWhatIsNearFrontalLargeAndFree) {
  const DetectorOptions options = Noiseless();
  const Eigen::Vector3d center = cam_from_site_.Inverse().translation;
  const std::vector<Detection> detections = Detect(options);
  ASSERT_GT(detections.size(), 150u);
  for (const Detection& detection : detections) {
    const CityLandmark& landmark = *detection.landmark;
    const Eigen::Vector3d to_camera = center - landmark.x_in_site;
    EXPECT_LE(to_camera.norm(), options.max_range_m);
    EXPECT_GE(landmark.normal.cast<double>().dot(to_camera.normalized()),
              std::cos(options.max_view_angle_rad) - 1e-6);
    EXPECT_GE(detection.keypoint.scale_px, options.min_scale_px - 1e-4);
    EXPECT_LE(detection.keypoint.scale_px, options.max_scale_px + 1e-4);
    EXPECT_FALSE(region_.IsHidden(center, landmark.x_in_site));
  }
}

TEST_F(OldTown, KeypointsAreWhereTheCameraSeesTheLandmark) {
  for (const Detection& detection : Detect(Noiseless())) {
    const auto pixel = kCamera.Project(cam_from_site_ * detection.landmark->x_in_site);
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(detection.keypoint.x_px, pixel->x(), 1e-3);
    EXPECT_NEAR(detection.keypoint.y_px, pixel->y(), 1e-3);
    // The orientation is the direction in which the pointer appears.
    const auto tip =
        kCamera.Project(cam_from_site_ * (detection.landmark->x_in_site +
                                          1e-4 * detection.landmark->pointer.cast<double>()));
    ASSERT_TRUE(tip);
    const double angle_rad = std::atan2(tip->y() - pixel->y(), tip->x() - pixel->x());
    EXPECT_NEAR(WrapAngleRad(detection.keypoint.orientation_rad - angle_rad), 0.0, 1e-2);
  }
}

TEST_F(OldTown, ScalesAreHalvedTwiceAsFarAway) {
  for (const Detection& detection : Detect(Noiseless())) {
    const Eigen::Vector3d x_in_cam = cam_from_site_ * detection.landmark->x_in_site;
    const double frontal_px = detection.landmark->size_m * kCamera.focal_px() / x_in_cam.norm() *
                              std::pow(x_in_cam.norm() / x_in_cam.z(), 1.5);
    EXPECT_LE(detection.keypoint.scale_px, frontal_px * 1.0001);
    EXPECT_GE(detection.keypoint.scale_px,
              frontal_px * std::sqrt(std::cos(DetectorOptions().max_view_angle_rad)) * 0.9999);
  }
}

TEST_F(OldTown, SmallKeypointsAreTheMostFrequent) {
  int num_small = 0, num_medium = 0, num_large = 0;
  for (const Detection& detection : Detect(Noiseless())) {
    num_small += detection.keypoint.scale_px < 2.0f;
    num_medium += detection.keypoint.scale_px >= 2.0f && detection.keypoint.scale_px < 4.0f;
    num_large += detection.keypoint.scale_px >= 4.0f;
  }
  EXPECT_GT(num_small, num_medium);
  EXPECT_GT(num_medium, num_large);
  EXPECT_GT(num_large, 10);
}

TEST_F(OldTown, AnotherLookFindsMuchButNotAllOfTheSame) {
  std::set<uint64_t> first;
  for (const Detection& detection : Detect(Noiseless(), 1)) {
    first.insert(detection.look.landmark);
  }
  int num_again = 0, num_second = 0;
  for (const Detection& detection : Detect(Noiseless(), 2)) {
    num_again += first.contains(detection.look.landmark);
    ++num_second;
  }
  const double repeatability = static_cast<double>(num_again) / num_second;
  EXPECT_GT(repeatability, 0.5);
  EXPECT_LT(repeatability, 0.85);
}

TEST_F(OldTown, ACrowdHidesWhatIsLow) {
  DetectorOptions options = Noiseless();
  const size_t without = Detect(options).size();
  options.crowd_share = 1.0;
  const Eigen::Vector3d center = cam_from_site_.Inverse().translation;
  const std::vector<Detection> with = Detect(options);
  EXPECT_LT(with.size(), without);
  for (const Detection& detection : with) {
    const Eigen::Vector3d way = detection.landmark->x_in_site - center;
    EXPECT_TRUE(way.head<2>().norm() < 4.0 || way.z() > 0.0);
  }
}

TEST_F(OldTown, KeepsTheStrongest) {
  DetectorOptions options = Noiseless();
  const std::vector<Detection> all = Detect(options);
  options.max_keypoints = 50;
  const std::vector<Detection> some = Detect(options);
  ASSERT_EQ(some.size(), 50u);
  for (size_t i = 0; i < some.size(); ++i) {
    EXPECT_EQ(some[i].look.landmark, all[i].look.landmark);
  }
}

TEST_F(OldTown, LooksAreMeasuredFromTheWallsNormal) {
  const Eigen::Vector3d center = cam_from_site_.Inverse().translation;
  int num_walls = 0;
  for (const Detection& detection : Detect(Noiseless())) {
    if (std::abs(detection.landmark->normal.z()) > 0.1f) {
      continue;
    }
    ++num_walls;
    // Normal, turned by the azimuth and raised by the elevation, points at the camera.
    const double yaw = std::atan2(detection.landmark->normal.y(), detection.landmark->normal.x()) +
                       detection.look.view_azimuth_rad;
    const double up = detection.look.view_elevation_rad;
    const Eigen::Vector3d way(std::cos(up) * std::cos(yaw), std::cos(up) * std::sin(yaw),
                              std::sin(up));
    EXPECT_LT((way - (center - detection.landmark->x_in_site).normalized()).norm(), 1e-5);
  }
  EXPECT_GT(num_walls, 100);
}

TEST(DetectorOptions, RefuseWhatCannotBe) {
  DetectorOptions options;
  options.max_scale_px = 0.5;
  EXPECT_THAT([&] { options.Validate(); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("detector.max_scale_px = 0.5")));
  options = {};
  options.position_noise = -1.0;
  EXPECT_THAT([&] { options.Validate(); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("detector.position_noise")));
}

}  // namespace
}  // namespace cairn
