#include "lab/city/phone_queries.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <vector>

#include "core/error.h"
#include "core/frames.h"
#include "core/statistics.h"
#include "lab/city/simulated_mapping.h"

namespace cairn {
namespace {

CityOptions SmallTownOptions(CityCharacter character = CityCharacter::kOldTown) {
  CityOptions options = CityPreset(character);
  options.area_km2 = 0.01;
  options.min_landmark_size_m = 0.05;
  return options;
}

// Without keypoints of landmarks and with few others, to be quick.
PhoneQueryOptions SensorsOnly(int num_queries) {
  PhoneQueryOptions options;
  options.num_queries = num_queries;
  options.num_keypoints = 10;
  options.detector.max_range_m = 2.0;
  return options;
}

TEST(PhoneQueries, StandOnTheSidewalkAndLookAcross) {
  for (const auto character : {CityCharacter::kOldTown, CityCharacter::kHighRise}) {
    CityOptions city_options = SmallTownOptions(character);
    city_options.area_km2 = 0.09;
    const City city(city_options);
    const DescriptorModel model({});
    const PhoneQueries queries(city, model, SensorsOnly(100));
    for (int i = 0; i < queries.size(); ++i) {
      const Eigen::Vector3d center = queries.Place(i).cam_from_site.Inverse().translation;
      const Eigen::Vector2d at = center.head<2>();
      EXPECT_TRUE(city.Contains(at));
      EXPECT_NEAR(center.z() - city.GroundM(at), 1.5, 0.4);
      bool is_on_sidewalk = false;
      for (const CityStreet& street : city.StreetsIn(BoxAroundPoint(at, 0.1))) {
        const double left_m = street.Direction().x() * (at - street.begin).y() -
                              street.Direction().y() * (at - street.begin).x();
        const double from_edge_m = 0.5 * street.width_m - std::abs(left_m);
        is_on_sidewalk |= from_edge_m > 0.0 && from_edge_m < std::max(1.0, street.sidewalk_m);
      }
      EXPECT_TRUE(is_on_sidewalk);
    }
  }
}

TEST(PhoneQueries, HaveTheShareOfMappedKeypointsThatIsAskedFor) {
  const City city(SmallTownOptions());
  const DescriptorModel model({});
  SimulatedMappingOptions mapping_options;
  const SimulatedMapping mapping(city, model, mapping_options);
  std::unordered_set<uint64_t> mapped;
  for (const TileId tile_id : mapping.Tiles()) {
    const MappedChunk chunk = mapping.MapTile(tile_id, 2);
    mapped.insert(chunk.city_landmarks.begin(), chunk.city_landmarks.end());
  }
  PhoneQueryOptions options;
  options.num_queries = 10;
  options.num_keypoints = 600;
  options.mapped_fraction = 0.05;
  options.mapped_log_sigma = 0.0;
  const PhoneQueries few(city, model, options);
  options.mapped_fraction = 0.0;
  const PhoneQueries none(city, model, options);
  int num_mapped = 0;
  for (int i = 0; i < few.size(); ++i) {
    const EvalQuery with = few.Make(i, mapped), without = none.Make(i, mapped);
    EXPECT_EQ(with.query.features.size(), 600);
    EXPECT_EQ(without.query.features.size(), 600);
    with.query.Validate();
    // Mapped keypoints come first; without them the list begins with the unmapped.
    const Keypoint& unmapped = without.query.features.keypoints[0];
    const auto& keypoints = with.query.features.keypoints;
    num_mapped += static_cast<int>(std::find_if(keypoints.begin(), keypoints.end(),
                                                [&](const Keypoint& keypoint) {
                                                  return keypoint.x_px == unmapped.x_px &&
                                                         keypoint.y_px == unmapped.y_px;
                                                }) -
                                   keypoints.begin());
  }
  EXPECT_NEAR(num_mapped / (600.0 * few.size()), 0.05, 0.01);
}

TEST(PhoneQueries, GpsErrorsAreLargeAndHeavyTailedAndTheReportIsHonestOnAverage) {
  CityOptions city_options = SmallTownOptions();
  city_options.area_km2 = 1.0;
  const City city(city_options);
  const DescriptorModel model({});
  const PhoneQueries queries(city, model, SensorsOnly(1500));
  std::vector<double> errors_m;
  int num_within = 0;
  for (int i = 0; i < queries.size(); ++i) {
    const EvalQuery query = queries.Make(i, {});
    ASSERT_TRUE(query.query.prior);
    const Geodetic truth = GeodeticFromEcef(query.cam_from_ecef.Inverse().translation);
    errors_m.push_back(GroundDistanceM(truth, query.query.prior->position));
    num_within += errors_m.back() < query.query.prior->accuracy_m;
  }
  EXPECT_GT(ValueAtShare(errors_m, 0.5), 8.0);
  EXPECT_LT(ValueAtShare(errors_m, 0.5), 20.0);
  EXPECT_GT(ValueAtShare(errors_m, 0.99), 3.0 * ValueAtShare(errors_m, 0.5));
  EXPECT_NEAR(num_within / 1500.0, 0.68, 0.08);
}

TEST(PhoneQueries, CanyonsPushPositionsAcrossTheStreet) {
  CityOptions city_options = SmallTownOptions();
  city_options.area_km2 = 1.0;
  const City city(city_options);
  const DescriptorModel model({});
  const PhoneQueries queries(city, model, SensorsOnly(1000));
  double sum_sq_along = 0.0, sum_sq_across = 0.0;
  for (int i = 0; i < queries.size(); ++i) {
    const EvalQuery query = queries.Make(i, {});
    const Eigen::Vector3d error =
        city.ecef_from_site().Inverse() * EcefFromGeodetic(query.query.prior->position) -
        queries.Place(i).cam_from_site.Inverse().translation;
    const double yaw_rad = queries.Place(i).street_yaw_rad;
    const double along_m = std::cos(yaw_rad) * error.x() + std::sin(yaw_rad) * error.y();
    const double across_m = -std::sin(yaw_rad) * error.x() + std::cos(yaw_rad) * error.y();
    sum_sq_along += along_m * along_m;
    sum_sq_across += across_m * across_m;
  }
  EXPECT_GT(sum_sq_across, 1.2 * sum_sq_along);
}

TEST(PhoneQueries, GravityAndIntrinsicsAreOffAsAskedFor) {
  const City city(SmallTownOptions());
  const DescriptorModel model({});
  PhoneQueryOptions options = SensorsOnly(500);
  options.noise.gravity_sigma_rad = 0.02;
  options.noise.focal_log_sigma = 0.01;
  const PhoneQueries queries(city, model, options);
  double sum_sq_tilt = 0.0, sum_sq_focal = 0.0;
  for (int i = 0; i < queries.size(); ++i) {
    const EvalQuery query = queries.Make(i, {});
    const Geodetic truth = GeodeticFromEcef(query.cam_from_ecef.Inverse().translation);
    const Eigen::Vector3d down =
        query.cam_from_ecef.rotation * (EcefFromEnu(truth).rotation * DownInEnu());
    const double tilt_rad = std::acos(std::min(1.0, down.dot(*query.query.down_in_cam)));
    sum_sq_tilt += tilt_rad * tilt_rad;
    const double focal = std::log(query.query.camera.focal_px() / options.focal_px);
    sum_sq_focal += focal * focal;
  }
  EXPECT_NEAR(std::sqrt(sum_sq_tilt / 2.0 / queries.size()), 0.02, 0.002);
  EXPECT_NEAR(std::sqrt(sum_sq_focal / queries.size()), 0.01, 0.001);
}

TEST(PhoneQueries, AQueryDependsOnItsNumberAlone) {
  const City city(SmallTownOptions());
  const DescriptorModel model({});
  PhoneQueryOptions options;
  options.num_queries = 5;
  const PhoneQueries five(city, model, options);
  options.num_queries = 9;
  const PhoneQueries nine(city, model, options);
  const EvalQuery a = five.Make(3, {}), b = nine.Make(3, {});
  EXPECT_EQ(a.query.features.descriptors, b.query.features.descriptors);
  EXPECT_EQ(a.query.prior->accuracy_m, b.query.prior->accuracy_m);
}

TEST(PhoneQueries, RefuseACityWithoutSidewalk) {
  CityOptions options = CityPreset(CityCharacter::kGrid);
  options.area_km2 = 1e-4;  // 10 m within a block.
  const City city(options);
  const DescriptorModel model({});
  EXPECT_THAT([&] { PhoneQueries(city, model, {}); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("no sidewalk")));
}

}  // namespace
}  // namespace cairn
