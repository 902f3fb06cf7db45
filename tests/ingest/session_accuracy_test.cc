// What an ingest says of the accuracy of its session, and what answers make of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/radius68.h"
#include "engine/localizer.h"
#include "eval/eval_query.h"
#include "eval/evaluation.h"
#include "ingest/colmap/colmap_reader.h"
#include "ingest/ingest_session.h"
#include "ingest/place/georegister.h"
#include "ingest/place/in_map_accuracy.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"
#include "support/test_data.h"

namespace cairn {
namespace {

constexpr size_t kCacheBytes = size_t{256} << 20;

std::optional<double> InMapAccuracyOf(const Reconstruction& reconstruction,
                                      const Sim3d& ecef_from_world) {
  return EstimateInMapAccuracy(reconstruction, PlaceSession(reconstruction, ecef_from_world, {}),
                               ecef_from_world.scale);
}

// Moves each camera by independent Gaussians, in meters, and the landmarks with them.
Reconstruction Bent(Reconstruction reconstruction, double sigma_m, double scale) {
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal(0.0, sigma_m / scale);
  for (ReconImage& image : reconstruction.images) {
    Rigid3d world_from_cam = image.cam_from_world.Inverse();
    const double x = normal(rng), y = normal(rng), z = normal(rng);
    world_from_cam.translation += Eigen::Vector3d(x, y, z);
    image.cam_from_world = world_from_cam.Inverse();
  }
  return reconstruction;
}

TEST(InMapAccuracy, IsWhatTheMatchesDoNotPredict) {
  const testing::StreetWorld world(testing::ShortStreet());
  const Sim3d ecef_from_world = world.EcefFromWorld();
  const auto exact = InMapAccuracyOf(world.Reconstruct(), ecef_from_world);
  ASSERT_TRUE(exact);
  EXPECT_LT(*exact, 0.01);
  const auto bent =
      InMapAccuracyOf(Bent(world.Reconstruct(), 0.05, ecef_from_world.scale), ecef_from_world);
  ASSERT_TRUE(bent);
  EXPECT_GT(*bent, 2.0 * *exact + 0.005);
  EXPECT_LT(*bent, 2.0 * kRadius68PerSigma3d * 0.05);
}

TEST(InMapAccuracy, IsUnknownForAFewPhotos) {
  testing::StreetWorldOptions options = testing::ShortStreet();
  options.length_m = 9.0;
  const testing::StreetWorld world(options);
  EXPECT_FALSE(InMapAccuracyOf(world.Reconstruct(), world.EcefFromWorld()));
}

TEST(UnpredictedRadius, MakesUpForWhatTheRadiiLeaveOut) {
  EXPECT_EQ(UnpredictedRadius68({}), 0.0);
  std::vector<PhotoDisagreement> photos;
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d of_matches(normal(rng), normal(rng), normal(rng));
    const Eigen::Vector3d of_map(normal(rng), normal(rng), normal(rng));
    photos.push_back({(0.3 * of_matches + 0.4 * of_map).norm(), kRadius68PerSigma3d * 0.3});
  }
  EXPECT_NEAR(UnpredictedRadius68(photos), kRadius68PerSigma3d * 0.4, 0.05);
}

class SessionsOfAStreet : public ::testing::Test {
 protected:
  // Ingests another visit of the street, misplaced by `off_m`.
  SessionAccuracy Ingest(const std::string& name, uint64_t view_seed, double off_m,
                         double earth_accuracy_m) {
    testing::StreetWorldOptions world_options = testing::ShortStreet();
    world_options.view_seed = view_seed;
    const testing::StreetWorld world(world_options);
    IngestOptions options = testing::SessionNamed(name);
    options.earth_accuracy_m = earth_accuracy_m;
    options.earth_accuracy_rad = 0.01;
    Sim3d ecef_from_world = world.EcefFromWorld();
    ecef_from_world.translation +=
        EcefFromEnu(world_options.origin).rotation * Eigen::Vector3d(off_m, 0.0, 0.0);
    IngestSession(world.Reconstruct(), ecef_from_world, options, &store_, {});
    return store_.Snapshot().FindSession(name)->accuracy.value_or(SessionAccuracy{});
  }

  testing::TempDir dir_;
  MapStore store_ = MapStore::Create(dir_.File("a.gpkg"));
};

TEST_F(SessionsOfAStreet, FollowTheMapAndStandOnEarthAsItDoes) {
  EXPECT_EQ(Ingest("first", 2, 0.0, 0.5).on_earth_m, 0.5);
  const SessionAccuracy second = Ingest("second", 3, 1.0, 4.0);
  EXPECT_NEAR(second.on_earth_m, 0.5, 1e-12);
  EXPECT_NEAR(second.on_earth_rad, 0.01, 1e-12);
  EXPECT_LT(second.in_map_m, 0.1);
}

TEST_F(SessionsOfAStreet, AreUnknownWithoutAnAccuracyOfThePlace) {
  Ingest("first", 2, 0.0, 0.0);
  EXPECT_FALSE(store_.Snapshot().FindSession("first")->accuracy);
}

TEST_F(SessionsOfAStreet, LendAnswersTheirAccuracy) {
  Ingest("first", 2, 0.0, 0.5);
  const testing::StreetWorld world(testing::ShortStreet());
  const Rigid3d cam_from_enu = testing::StreetWorld::LookAlong({20.0, 0.0, 1.6}, 0.4);
  LocalizeQuery query;
  query.camera = world.camera();
  query.features = world.Photograph(cam_from_enu, 99);
  query.prior.emplace().position =
      GeodeticFromEcef(EcefFromEnu(world.options().origin) * cam_from_enu.Inverse().translation);
  const auto store =
      std::make_shared<const MapStore>(MapStore::Open(dir_.File("a.gpkg"), OpenMode::kReadOnly));
  const Localizer localizer(store, {}, kCacheBytes);
  const LocalizeResult result = localizer.Localize(query);
  ASSERT_TRUE(result.localized);
  EXPECT_NEAR(result.map_accuracy_m, 0.5, 1e-9);
  EXPECT_NEAR(result.map_accuracy_rad, 0.01, 1e-9);
  EXPECT_LT(result.position_accuracy_m, 0.2);
  EXPECT_NEAR(Radius68(result.covariance.bottomRightCorner<3, 3>()), result.position_accuracy_m,
              1e-12);
}

// Every second photo of a model, from `first` on, makes a map, and asks for the others.
EvalReport AskOtherHalf(const ColmapInput& input, const std::string& positions_path, size_t first) {
  std::vector<std::string> names;
  const Reconstruction whole = ReadColmap(input);
  for (const ReconImage& image : whole.images) {
    names.push_back(image.name);
  }
  std::sort(names.begin(), names.end());
  ColmapInput half = input;
  for (size_t i = first; i < names.size(); i += 2) {
    half.image_names.push_back(names[i]);
  }
  const Reconstruction mapped = ReadColmap(half);
  const Georegistration place = Georegister(
      mapped,
      positions_path.empty() ? GpsPositions(mapped, 5.0) : ReadCameraPositions(positions_path), {});
  const testing::TempDir dir;
  MapStore store = MapStore::Create(dir.File("half.gpkg"));
  IngestOptions options;
  options.session_name = "half";
  options.earth_accuracy_m = place.accuracy.position_m;
  IngestSession(mapped, place.ecef_from_world, options, &store, {});
  std::vector<EvalQuery> queries = QueriesFromReconstruction(whole, place.ecef_from_world, "");
  std::erase_if(queries, [&](const EvalQuery& query) {
    return std::count(half.image_names.begin(), half.image_names.end(), query.name) > 0;
  });
  for (EvalQuery& query : queries) {
    query.reference_frame = ReferenceFrame::kMap;
  }
  AddNoisyPriors({}, &queries);
  const Localizer localizer = Localizer::Open(dir.File("half.gpkg"), {}, kCacheBytes);
  return Evaluate(queries, [&](const EvalQuery& query) { return localizer.Localize(query.query); },
                  {});
}

// What the halves of a place say of each other.
struct HalvesOf {
  HalvesOf(const ColmapInput& input, const std::string& positions_path)
      : reports{AskOtherHalf(input, positions_path, 0), AskOtherHalf(input, positions_path, 1)} {}

  // Over the answers of both.
  double Mean(Interval EvalReport::*figure) const {
    double sum = 0.0, count = 0.0;
    for (const EvalReport& report : reports) {
      sum += report.num_localized * (report.*figure).value;
      count += report.num_localized;
    }
    return sum / count;
  }

  std::array<EvalReport, 2> reports;
};

// The radii of a place hold 68 % of its errors, whether these are millimeters or decimeters. 28 to
// 51 answers: the limits are two standard deviations of such a share, or less.
void ExpectHonestRadii(const char* place, const HalvesOf& halves) {
  const double positions = halves.Mean(&EvalReport::position_coverage);
  const double rotations = halves.Mean(&EvalReport::rotation_coverage);
  std::printf(
      "%s: %.4f m in the median, %.2f of the positions and %.2f of the rotations within "
      "their radii\n",
      place, halves.Mean(&EvalReport::median_position_error_m), positions, rotations);
  EXPECT_GT(positions, 0.50);
  EXPECT_LT(positions, 0.86);
  EXPECT_GT(rotations, 0.45);
}

TEST(RadiiOfRealPhotos, HoldOnADrive) {
  CAIRN_SKIP_WITHOUT_DATA("kitti_vo_2x51");
  const auto dir = testing::TestDataDir() / "kitti_vo_2x51";
  ExpectHonestRadii(
      "KITTI",
      HalvesOf({(dir / "colmap_model_seq1").string(), (dir / "database_seq1.db").string(), {}},
               (dir / "georef_seq1.csv").string()));
}

TEST(RadiiOfRealPhotos, HoldOnAWalk) {
  CAIRN_SKIP_WITHOUT_DATA("street_lund");
  const auto dir = testing::TestDataDir() / "street_lund";
  ExpectHonestRadii(
      "Lund", HalvesOf({(dir / "colmap_model").string(), (dir / "database.db").string(), {}}, ""));
}

TEST(RadiiOfRealPhotos, HoldInFrontOfAFacade) {
  CAIRN_SKIP_WITHOUT_DATA("facades_strecha");
  const auto dir = testing::TestDataDir() / "facades_strecha" / "colmap_Herz-Jesus-both";
  ExpectHonestRadii("Herz-Jesus", HalvesOf({dir.string(), (dir / "database.db").string(), {}},
                                           (dir / "georef.csv").string()));
}

}  // namespace
}  // namespace cairn
