#include "eval/eval_query.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/frames.h"

namespace cairn {
namespace {

const Geodetic kPlace = Geodetic::FromDegrees(47.3769, 8.5417, 408.0);

// A camera at kPlace, tilted and turned.
EvalQuery MakeQuery(const std::string& name) {
  EvalQuery query;
  query.name = name;
  const Rigid3d cam_from_enu(ExpSo3(Eigen::Vector3d(1.2, -0.4, 0.3)), Eigen::Vector3d::Zero());
  query.cam_from_ecef = cam_from_enu * EcefFromEnu(kPlace).Inverse();
  return query;
}

std::vector<EvalQuery> MakeQueries(int count) {
  std::vector<EvalQuery> queries;
  for (int i = 0; i < count; ++i) {
    queries.push_back(MakeQuery(fmt::format("query {}", i)));
  }
  return queries;
}

Eigen::Vector3d TrueDownInCam(const EvalQuery& query) {
  return (query.cam_from_ecef * EcefFromEnu(kPlace)).rotation * DownInEnu();
}

TEST(AddNoisyPriors, HasTheStatisticsItPromises) {
  std::vector<EvalQuery> queries = MakeQueries(4000);
  PriorNoiseOptions options;
  AddNoisyPriors(options, &queries);
  const Rigid3d enu_from_ecef = EcefFromEnu(kPlace).Inverse();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), sum_of_squares = Eigen::Vector3d::Zero();
  double sum_sq_tilt = 0.0;
  int num_within_accuracy = 0;
  for (const EvalQuery& query : queries) {
    const PositionPrior& prior = *query.query.prior;
    Eigen::Vector3d error = enu_from_ecef * EcefFromGeodetic(prior.position);
    error.z() = prior.position.h_m - kPlace.h_m;
    sum += error;
    sum_of_squares += error.cwiseAbs2();
    num_within_accuracy += error.head<2>().norm() <= prior.accuracy_m ? 1 : 0;
    const double tilt =
        std::acos(std::clamp(TrueDownInCam(query).dot(*query.query.down_in_cam), -1.0, 1.0));
    sum_sq_tilt += tilt * tilt;
  }
  const double count = static_cast<double>(queries.size());
  EXPECT_NEAR((sum / count).head<2>().norm(), 0.0, 0.6);
  EXPECT_NEAR(std::sqrt(sum_of_squares.x() / count), 10.0, 0.4);
  EXPECT_NEAR(std::sqrt(sum_of_squares.y() / count), 10.0, 0.4);
  EXPECT_NEAR(std::sqrt(sum_of_squares.z() / count), 5.0, 0.2);
  EXPECT_NEAR(num_within_accuracy / count, 0.68, 0.025);
  // Two axes of tilt: the mean squared angle is twice the variance.
  EXPECT_NEAR(std::sqrt(0.5 * sum_sq_tilt / count), options.gravity_sigma_rad,
              0.04 * options.gravity_sigma_rad);
}

TEST(AddNoisyPriors, GivesAQueryTheSameNoiseInAnyList) {
  std::vector<EvalQuery> all = MakeQueries(5), one = {MakeQuery("query 3")};
  AddNoisyPriors({}, &all);
  AddNoisyPriors({}, &one);
  EXPECT_EQ(all[3].query.prior->position.lat_rad, one[0].query.prior->position.lat_rad);
  EXPECT_EQ(*all[3].query.down_in_cam, *one[0].query.down_in_cam);
  EXPECT_NE(all[2].query.prior->position.lat_rad, one[0].query.prior->position.lat_rad);
}

TEST(AddNoisyPriors, DependsOnTheSeed) {
  std::vector<EvalQuery> a = MakeQueries(1), b = MakeQueries(1);
  AddNoisyPriors({.seed = 1}, &a);
  AddNoisyPriors({.seed = 2}, &b);
  EXPECT_NE(a[0].query.prior->position.lat_rad, b[0].query.prior->position.lat_rad);
}

TEST(AddNoisyPriors, LeavesOutWhatIsSwitchedOff) {
  std::vector<EvalQuery> with = MakeQueries(1), without = MakeQueries(1);
  AddNoisyPriors({}, &with);
  AddNoisyPriors({.with_prior = false}, &without);
  EXPECT_FALSE(without[0].query.prior.has_value());
  EXPECT_EQ(*without[0].query.down_in_cam, *with[0].query.down_in_cam);
  AddNoisyPriors({.with_gravity = false}, &without);
  EXPECT_TRUE(without[0].query.prior.has_value());
  EXPECT_FALSE(without[0].query.down_in_cam.has_value());
}

TEST(OffsetPriors, MovesEachByTheDistanceInADirectionOfItsOwn) {
  constexpr double kOffsetM = 60.0;
  std::vector<EvalQuery> queries = MakeQueries(20);
  AddNoisyPriors({}, &queries);
  const std::vector<EvalQuery> before = queries;
  OffsetPriors(kOffsetM, 1, &queries);
  int num_north = 0;
  for (size_t i = 0; i < queries.size(); ++i) {
    const PositionPrior& moved = *queries[i].query.prior;
    const PositionPrior& from = *before[i].query.prior;
    EXPECT_NEAR(GroundDistanceM(moved.position, from.position), kOffsetM, 0.01);
    EXPECT_EQ(moved.position.h_m, from.position.h_m);
    EXPECT_EQ(moved.accuracy_m, from.accuracy_m);
    num_north += moved.position.lat_rad > from.position.lat_rad;
  }
  EXPECT_GT(num_north, 0);
  EXPECT_LT(num_north, 20);
}

TEST(OffsetPriors, LeavesQueriesWithoutPriorAlone) {
  std::vector<EvalQuery> queries = MakeQueries(1);
  AddNoisyPriors({.with_prior = false}, &queries);
  OffsetPriors(60.0, 1, &queries);
  EXPECT_FALSE(queries[0].query.prior.has_value());
}

TEST(AddNoisyPriors, WithoutNoiseGivesTheTruthAsAValidQuery) {
  std::vector<EvalQuery> queries = MakeQueries(1);
  AddNoisyPriors({.position_sigma_m = 0.0, .height_sigma_m = 0.0, .gravity_sigma_rad = 0.0},
                 &queries);
  EXPECT_LT(GroundDistanceM(queries[0].query.prior->position, kPlace), 1e-6);
  EXPECT_NEAR(queries[0].query.prior->position.h_m, kPlace.h_m, 1e-6);
  EXPECT_LT((TrueDownInCam(queries[0]) - *queries[0].query.down_in_cam).norm(), 1e-9);
  EXPECT_NO_THROW(queries[0].query.Validate());
}

TEST(PriorNoiseOptions, RefusesNonsense) {
  EXPECT_THROW(PriorNoiseOptions{.position_sigma_m = -1.0}.Validate(), Error);
  EXPECT_THROW(PriorNoiseOptions{.height_sigma_m = NAN}.Validate(), Error);
  EXPECT_THROW(PriorNoiseOptions{.gravity_sigma_rad = 2.0}.Validate(), Error);
}

TEST(QueriesFromReconstruction, CarriesFeaturesPathsAndPoses) {
  Reconstruction reconstruction;
  reconstruction.cameras = {Camera(CameraModel::kPinhole, 320, 240, {200.0, 200.0, 160.0, 120.0})};
  ReconImage image;
  image.name = "a.jpg";
  image.cam_from_world = Rigid3d(ExpSo3(Eigen::Vector3d(0.1, 0.2, 0.3)), Eigen::Vector3d(1, 2, 3));
  image.features.keypoints.resize(2);
  image.features.descriptors = DescriptorMatrix(DescriptorMatrix::Zero(2, 128));
  reconstruction.images = {image};
  Sim3d ecef_from_world;
  ecef_from_world.scale = 2.0;
  ecef_from_world.translation = Eigen::Vector3d(100.0, 0.0, 0.0);
  const auto queries = QueriesFromReconstruction(reconstruction, ecef_from_world, "photos");
  ASSERT_EQ(queries.size(), 1u);
  EXPECT_EQ(queries[0].name, "a.jpg");
  EXPECT_EQ(queries[0].image_path, "photos/a.jpg");
  EXPECT_EQ(queries[0].query.camera.width_px(), 320);
  EXPECT_EQ(queries[0].query.features.size(), 2);
  const Eigen::Vector3d center_in_world = image.cam_from_world.Inverse().translation;
  EXPECT_LT(
      (queries[0].cam_from_ecef.Inverse().translation - ecef_from_world * center_in_world).norm(),
      1e-9);
}

}  // namespace
}  // namespace cairn
