#include "ingest/place/control_points.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "core/error.h"
#include "support/expect_error.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Points of a street as a survey and the photos have them; the first is seen too rarely.
std::vector<ControlPoint> PointsOf(const StreetWorld& world, const Reconstruction& street,
                                   const std::vector<Eigen::Vector3d>& points_in_enu) {
  std::vector<ControlPoint> points;
  for (const Eigen::Vector3d& x_in_enu : points_in_enu) {
    ControlPoint& point = points.emplace_back();
    point.name = fmt::format("p{}", points.size());
    point.position = GeodeticFromEcef(EcefFromEnu(world.options().origin) * x_in_enu);
    point.accuracy_m = 0.05;
    for (const ReconImage& image : street.images) {
      const auto pixel = world.camera().Project(image.cam_from_world *
                                                (world.options().world_from_enu * x_in_enu));
      if (pixel && world.camera().Contains(*pixel)) {
        point.observations.push_back({image.name, *pixel});
      }
    }
  }
  return points;
}

const std::vector<Eigen::Vector3d> kSpread = {
    {20.0, 8.0, 2.0}, {35.0, -8.0, 6.0}, {50.0, 8.0, 4.0}, {60.0, -8.0, 1.0}};

TEST(ControlPoints, PlaceAModelWithoutPositionsOfItsPhotos) {
  const StreetWorld world;
  Reconstruction street = world.Reconstruct();
  for (ReconImage& image : street.images) {
    image.gps.reset();
  }
  const Georegistration result = GeoregisterByControl(street, PointsOf(world, street, kSpread), {});
  EXPECT_EQ(result.num_positions, 4);
  EXPECT_EQ(result.num_inliers, 4);
  EXPECT_LT(result.max_residual_m, 1e-3);
  const Sim3d truth = world.EcefFromWorld();
  for (const ReconImage& image : street.images) {
    const Eigen::Vector3d center = image.cam_from_world.Inverse().translation;
    EXPECT_LT((result.ecef_from_world * center - truth * center).norm(), 1e-2) << image.name;
  }
  EXPECT_EQ(result.up.source, "the control points");
}

TEST(ControlPoints, AWrongPointDoesNotCount) {
  const StreetWorld world;
  const Reconstruction street = world.Reconstruct();
  std::vector<Eigen::Vector3d> spread = kSpread;
  spread.insert(spread.end(), {{28.0, 8.0, 7.0}, {42.0, -8.0, 3.0}, {55.0, 8.0, 8.0}});
  std::vector<ControlPoint> points = PointsOf(world, street, spread);
  points[1].position = Geodetic::FromDegrees(47.3773, 8.5417, 408.0);
  const Georegistration result = GeoregisterByControl(street, points, {});
  EXPECT_EQ(result.num_inliers, 6);
  EXPECT_EQ(result.worst_image, "p2");
}

TEST(ControlPoints, SaysWhichPointsDoNotCountAndWhy) {
  const StreetWorld world;
  const Reconstruction street = world.Reconstruct();
  std::vector<Eigen::Vector3d> spread = kSpread;
  spread.emplace_back(42.0, -8.0, 2.0);
  std::vector<ControlPoint> points = PointsOf(world, street, spread);
  points[3].observations.resize(1);
  ASSERT_GT(points[4].observations.size(), 2u);
  points[4].observations.resize(2);
  points[4].observations[1].pixel.y() += 300.0;
  const Georegistration result = GeoregisterByControl(street, points, {});
  EXPECT_EQ(result.num_positions, 3);
  EXPECT_THAT(result.notes, ElementsAre(HasSubstr("p4 does not count: 1 photos"),
                                        HasSubstr("p5 does not count: the rays")));
  points[2].observations.clear();
  ExpectError([&] { GeoregisterByControl(street, points, {}); }, ErrorCode::kBadInput,
              "at least 3 are needed; the control point p3");
}

TEST(ControlPoints, OnALineAreRefused) {
  const StreetWorld world;
  const Reconstruction street = world.Reconstruct();
  const std::vector<ControlPoint> points =
      PointsOf(world, street, {{20.0, 8.0, 2.0}, {35.0, 8.0, 2.0}, {50.0, 8.0, 2.0}});
  ExpectError([&] { GeoregisterByControl(street, points, {}); }, ErrorCode::kBadInput, "on a line");
}

TEST(ControlPoints, PhotosOfAnotherModelAreRefused) {
  const StreetWorld world;
  const Reconstruction street = world.Reconstruct();
  std::vector<ControlPoint> points = PointsOf(world, street, kSpread);
  for (ControlPoint& point : points) {
    for (ControlObservation& observation : point.observations) {
      observation.image_name = "other_" + observation.image_name;
    }
  }
  ExpectError([&] { GeoregisterByControl(street, points, {}); }, ErrorCode::kBadInput,
              "none of the photos that show control points is in the model");
}

class ControlPointFiles : public ::testing::Test {
 protected:
  std::vector<ControlPoint> Read(const std::string& text) const {
    std::ofstream(dir_.File("points.csv")) << text;
    return ReadControlPoints(dir_.File("points.csv"));
  }
  TempDir dir_;
};

TEST_F(ControlPointFiles, HaveARowForEachObservation) {
  const std::vector<ControlPoint> points = Read(
      "point,image,x_px,y_px,lat_deg,lon_deg,h_m,accuracy_m\n"
      "door,a.jpg,10.5,20,47,8,400,0.02\n"
      "sign,a.jpg,300,40.25,47.001,8,401,0.03\n"
      "door,\"b, 2.jpg\",11,21,47,8,400,0.02\n");
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].name, "door");
  EXPECT_EQ(points[0].accuracy_m, 0.02);
  ASSERT_EQ(points[0].observations.size(), 2u);
  EXPECT_EQ(points[0].observations[1].image_name, "b, 2.jpg");
  EXPECT_EQ(points[1].observations[0].pixel, Eigen::Vector2d(300, 40.25));
}

TEST_F(ControlPointFiles, FaultsAreNamed) {
  const std::string header = "point,lat_deg,lon_deg,h_m,image,x_px,y_px\n";
  const auto refused = [&](const std::string& text, const std::string& why) {
    ExpectError([&] { Read(text); }, ErrorCode::kBadInput, why);
  };
  refused("point,lat_deg\n", "no column 'lon_deg'");
  refused(header, "no point below the header");
  refused(header + "a,47,8,400,a.jpg,1,2\na,47.1,8,400,b.jpg,1,2\n", "line 3: the point a has");
  refused(header + "a,97,8,400,a.jpg,1,2\n", "line 2");
  refused(header + "a,47,8,-9999,a.jpg,1,2\n",
          "line 2: column h_m: the point a cannot be at -9999 m");
  refused(header + "a,47,8,400,a.jpg,1,nan\n", "column y_px");
}

}  // namespace
}  // namespace cairn::testing
