#include "core/wire/inner_frame.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/angles.h"

namespace cairn {
namespace {

constexpr InnerFrame kAll[] = {InnerFrame::kFlu, InnerFrame::kRdf, InnerFrame::kRub,
                               InnerFrame::kEus};
const Geodetic kZurich = Geodetic::FromDegrees(47.3769, 8.5417, 408.0);

// A level camera at kZurich; `heading_rad` counts from north over east.
Rigid3d LevelCamera(double heading_rad) {
  const Eigen::Vector3d forward(std::sin(heading_rad), std::cos(heading_rad), 0.0);
  const Eigen::Vector3d down(0.0, 0.0, -1.0);
  Eigen::Matrix3d enu_from_cam;
  enu_from_cam << down.cross(forward), down, forward;
  const Rigid3d ecef_from_enu = EcefFromEnu(kZurich);
  return Rigid3d(ecef_from_enu.rotation * Eigen::Quaterniond(enu_from_cam),
                 EcefFromGeodetic(kZurich))
      .Inverse();
}

void ExpectQuaternion(const Eigen::Quaterniond& q, double x, double y, double z, double w) {
  EXPECT_NEAR(q.x(), x, 1e-9);
  EXPECT_NEAR(q.y(), y, 1e-9);
  EXPECT_NEAR(q.z(), z, 1e-9);
  EXPECT_NEAR(q.w(), w, 1e-9);
}

TEST(InnerFrame, AFluCameraThatLooksEastHasTheIdentity) {
  ExpectQuaternion(GeoPoseFromCamera(LevelCamera(kPi / 2), InnerFrame::kFlu).enu_from_inner, 0, 0,
                   0, 1);
}

TEST(InnerFrame, AFluCameraThatLooksNorthIsTurnedLeftAboutUp) {
  ExpectQuaternion(GeoPoseFromCamera(LevelCamera(0.0), InnerFrame::kFlu).enu_from_inner, 0, 0,
                   std::sqrt(0.5), std::sqrt(0.5));
}

TEST(InnerFrame, ARubCameraThatLooksNorthIsTiltedUpAboutEast) {
  // Right is east; the camera's up (0, 1, 0) has to become (0, 0, 1): +90 degrees about x.
  ExpectQuaternion(GeoPoseFromCamera(LevelCamera(0.0), InnerFrame::kRub).enu_from_inner,
                   std::sqrt(0.5), 0, 0, std::sqrt(0.5));
}

TEST(InnerFrame, ARdfCameraThatLooksNorthIsTiltedDownAboutEast) {
  // Down (0, 1, 0) has to become (0, 0, -1), forward (0, 0, 1) north: -90 degrees about x.
  ExpectQuaternion(GeoPoseFromCamera(LevelCamera(0.0), InnerFrame::kRdf).enu_from_inner,
                   -std::sqrt(0.5), 0, 0, std::sqrt(0.5));
}

TEST(InnerFrame, AnEusCameraThatLooksNorthBecomesArCoresIdentity) {
  const Eigen::Quaterniond q = GeoPoseFromCamera(LevelCamera(0.0), InnerFrame::kEus).enu_from_inner;
  const Eigen::Quaterniond eus_from_enu(std::sqrt(0.5), -std::sqrt(0.5), 0.0, 0.0);
  ExpectQuaternion(eus_from_enu * q, 0, 0, 0, 1);
}

TEST(InnerFrame, AxesPointWhereTheirLettersSay) {
  const Eigen::Vector3d right(1, 0, 0), down(0, 1, 0), forward(0, 0, 1);
  Eigen::Matrix3d expected;
  expected << forward, -right, -down;
  EXPECT_EQ(CamFromInner(InnerFrame::kFlu), expected);
  expected << right, down, forward;
  EXPECT_EQ(CamFromInner(InnerFrame::kRdf), expected);
  expected << right, -down, -forward;
  EXPECT_EQ(CamFromInner(InnerFrame::kRub), expected);
  for (const InnerFrame frame : kAll) {
    EXPECT_DOUBLE_EQ(CamFromInner(frame).determinant(), 1.0) << InnerFrameName(frame);
  }
}

TEST(InnerFrame, GeoPoseRoundTrips) {
  for (const InnerFrame frame : kAll) {
    for (const double heading_rad : {-3.0, -1.0, 0.3, 2.0}) {
      const Rigid3d cam_from_ecef =
          Rigid3d(ExpSo3({0.2, -0.3, 0.5}), {0.0, 0.0, 0.0}) * LevelCamera(heading_rad);
      const GeoPose geopose = GeoPoseFromCamera(cam_from_ecef, frame);
      EXPECT_NEAR(geopose.position.lat_rad, kZurich.lat_rad, 1e-12);
      EXPECT_GE(geopose.enu_from_inner.w(), 0.0);
      const Rigid3d back = CameraFromGeoPose(geopose, frame);
      EXPECT_LT(RotationAngleRad(back.rotation, cam_from_ecef.rotation), 1e-9);
      EXPECT_LT((back.Inverse().translation - cam_from_ecef.Inverse().translation).norm(), 1e-6);
    }
  }
}

TEST(InnerFrame, NamesRoundTrip) {
  for (const InnerFrame frame : kAll) {
    EXPECT_EQ(InnerFrameFromName(InnerFrameName(frame)), frame);
  }
  EXPECT_EQ(InnerFrameFromName("flu"), std::nullopt);
}

}  // namespace
}  // namespace cairn
