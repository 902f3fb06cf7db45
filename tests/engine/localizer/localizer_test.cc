#include "engine/localizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"
#include "core/frames.h"
#include "ingest/ingest_session.h"
#include "storage/descriptor_codec.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::AnyOf;
using testing::StreetWorld;
using testing::StreetWorldOptions;
using testing::TempDir;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

// A map of one or more streets and the localizer over it.
class MappedStreets {
 public:
  explicit MappedStreets(const std::vector<StreetWorld>& worlds,
                         const LocalizerOptions& options = {})
      : store_(std::make_shared<MapStore>(MapStore::Create(dir_.File("map.gpkg")))),
        localizer_(store_, std::make_shared<TileCache>(size_t{1} << 28), options) {
    for (const StreetWorld& world : worlds) {
      Add(world);
    }
  }

  void Add(const StreetWorld& world) {
    IngestOptions options;
    options.session_name = "street " + std::to_string(num_streets_++);
    options.codebook.max_training_descriptors = 5000;
    IngestSession(world.Reconstruct(), world.EcefFromWorld(), options, store_.get(), {});
  }

  const MapStore& store() const { return *store_; }
  const Localizer& localizer() const { return localizer_; }
  // Another localizer over the same map, with a cache of its own.
  Localizer WithOptions(const LocalizerOptions& options) const {
    return {store_, std::make_shared<TileCache>(size_t{1} << 28), options};
  }

 private:
  TempDir dir_;
  std::shared_ptr<MapStore> store_;
  Localizer localizer_;
  int num_streets_ = 0;
};

// Somewhere a keyframe was not: lower, off the centre line, turned.
Rigid3d QueryPose(double x_m) { return StreetWorld::LookAlong({x_m, -1.5, 1.2}, 0.2, 0.03); }

LocalizeQuery QueryAt(const StreetWorld& world, const Rigid3d& cam_from_enu) {
  LocalizeQuery query;
  query.camera = world.camera();
  query.features = world.Photograph(cam_from_enu, /*seed=*/99);
  const Rigid3d ecef_from_enu = EcefFromEnu(world.options().origin);
  PositionPrior prior;
  prior.position = GeodeticFromEcef(
      ecef_from_enu * (cam_from_enu.Inverse().translation + Eigen::Vector3d(6.0, -5.0, 3.0)));
  query.prior = prior;
  query.down_in_cam = cam_from_enu.rotation * DownInEnu();
  return query;
}

void ExpectPose(const LocalizeResult& result, const StreetWorld& world, const Rigid3d& cam_from_enu,
                double max_error_m, double max_error_rad) {
  ASSERT_TRUE(result.localized) << NotLocalizedReasonName(result.reason);
  const Rigid3d cam_from_ecef = cam_from_enu * EcefFromEnu(world.options().origin).Inverse();
  EXPECT_LT(
      (result.cam_from_ecef.Inverse().translation - cam_from_ecef.Inverse().translation).norm(),
      max_error_m);
  EXPECT_LT(RotationAngleRad(result.cam_from_ecef.rotation, cam_from_ecef.rotation), max_error_rad);
}

class LocalizerOnOneStreet : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    world_ = new StreetWorld();
    map_ = new MappedStreets({*world_});
  }
  static void TearDownTestSuite() {
    delete map_;
    delete world_;
  }
  static const Localizer& localizer() { return map_->localizer(); }

  static StreetWorld* world_;
  static MappedStreets* map_;
};
StreetWorld* LocalizerOnOneStreet::world_ = nullptr;
MappedStreets* LocalizerOnOneStreet::map_ = nullptr;

TEST_F(LocalizerOnOneStreet, FindsPosesBetweenTheKeyframes) {
  for (const double x_m : {4.0, 17.5, 31.0, 44.5}) {
    const Rigid3d cam_from_enu = QueryPose(x_m);
    ExpectPose(localizer().Localize(QueryAt(*world_, cam_from_enu)), *world_, cam_from_enu, 0.05,
               0.1 * kRadPerDeg);
  }
}

TEST_F(LocalizerOnOneStreet, WorksWithEveryAlternative) {
  std::vector<LocalizerOptions> alternatives;
  for (const IndexKind kind : {IndexKind::kInvertedLists, IndexKind::kInvertedMultiIndex,
                               IndexKind::kKdTree, IndexKind::kExhaustive}) {
    alternatives.emplace_back().matching.index.kind = kind;
  }
  for (const OutlierFilter filter :
       {OutlierFilter::kVoting3d, OutlierFilter::kCovisibility, OutlierFilter::kNone}) {
    alternatives.emplace_back().voting.filter = filter;
  }
  alternatives.emplace_back().matching.distance_filter = DistanceFilter::kNone;
  LocalizerOptions& word_ratio = alternatives.emplace_back();
  word_ratio.matching.distance_filter = DistanceFilter::kWordRatio;
  word_ratio.matching.index.num_reference_words = 50;
  alternatives.emplace_back().pose.solver = MinimalSolver::kP3p;
  const Rigid3d cam_from_enu = QueryPose(20.0);
  for (const LocalizerOptions& options : alternatives) {
    const LocalizeResult result =
        map_->WithOptions(options).Localize(QueryAt(*world_, cam_from_enu));
    ExpectPose(result, *world_, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
  }
}

TEST_F(LocalizerOnOneStreet, RefinesWhenToldTo) {
  const LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  LocalizerOptions options;
  options.refinement.mode = RefinementMode::kAlways;
  EXPECT_GT(map_->WithOptions(options).Localize(query).counters.num_refined_keyframes, 0);
  options.refinement.mode = RefinementMode::kNever;
  options.refinement.good_effective_inliers = 1e6;
  EXPECT_EQ(map_->WithOptions(options).Localize(query).counters.num_refined_keyframes, 0);
  options.refinement.mode = RefinementMode::kWhenWeak;
  EXPECT_GT(map_->WithOptions(options).Localize(query).counters.num_refined_keyframes, 0);
}

TEST_F(LocalizerOnOneStreet, ReportsItsEvidence) {
  const LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  const LocalizeResult result = localizer().Localize(query);
  ASSERT_TRUE(result.localized);
  EXPECT_GE(result.matches.size(), 20u);
  for (const LocalizeMatch& match : result.matches) {
    EXPECT_EQ(match.pixel.x(), query.features.keypoints[match.keypoint_idx].x_px);
    const auto pixel = query.camera.Project(result.cam_from_anchor * match.x_in_anchor);
    ASSERT_TRUE(pixel);
    EXPECT_NEAR((*pixel - match.pixel).norm(), match.error_px, 1e-9);
  }
  EXPECT_FALSE(result.tiles.empty());
  EXPECT_EQ(result.counters.num_keypoints, query.features.size());
  EXPECT_TRUE(result.counters.used_prior);
  EXPECT_TRUE(result.counters.used_gravity);
  EXPECT_GT(result.counters.num_matches, 0);
  EXPECT_GT(result.counters.num_candidates, 0);
  EXPECT_GT(result.confidence, 0.5);
  EXPECT_GT(result.position_accuracy_m, 0.0);
  EXPECT_LT(result.position_accuracy_m, 0.5);
  EXPECT_EQ(result.map_version, map_->store().Snapshot().version());
}

TEST_F(LocalizerOnOneStreet, WorksWithoutGravity) {
  const Rigid3d cam_from_enu = QueryPose(20.0);
  LocalizeQuery query = QueryAt(*world_, cam_from_enu);
  query.down_in_cam.reset();
  const LocalizeResult result = localizer().Localize(query);
  ExpectPose(result, *world_, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
  EXPECT_FALSE(result.counters.used_gravity);
}

TEST_F(LocalizerOnOneStreet, WorksWithoutPrior) {
  const Rigid3d cam_from_enu = QueryPose(20.0);
  LocalizeQuery query = QueryAt(*world_, cam_from_enu);
  query.prior.reset();
  const LocalizeResult result = localizer().Localize(query);
  ExpectPose(result, *world_, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
  EXPECT_FALSE(result.counters.used_prior);
}

TEST_F(LocalizerOnOneStreet, ToleratesGravityTwoDegreesOff) {
  const Rigid3d cam_from_enu = QueryPose(30.0);
  LocalizeQuery query = QueryAt(*world_, cam_from_enu);
  query.down_in_cam = ExpSo3({2.0 * kRadPerDeg, 0.0, 0.0}) * *query.down_in_cam;
  ExpectPose(localizer().Localize(query), *world_, cam_from_enu, 0.1, 0.3 * kRadPerDeg);
}

TEST_F(LocalizerOnOneStreet, SaysNoCoverageFarAway) {
  LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  query.prior->position = Geodetic::FromDegrees(48.0, 9.0, 400.0);
  const LocalizeResult result = localizer().Localize(query);
  EXPECT_FALSE(result.localized);
  EXPECT_EQ(result.reason, NotLocalizedReason::kNoCoverage);
}

TEST_F(LocalizerOnOneStreet, NeverAnswersOutsideThePriorsRegion) {
  LocalizeQuery query = QueryAt(*world_, QueryPose(50.0));
  query.prior->position =
      GeodeticFromEcef(EcefFromEnu(world_->options().origin) * Eigen::Vector3d(-20.0, 0.0, 1.6));
  query.prior->accuracy_m = 5.0;
  EXPECT_FALSE(localizer().Localize(query).localized);
}

TEST_F(LocalizerOnOneStreet, SaysTooFewFeatures) {
  LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  query.features.keypoints.resize(3);
  query.features.descriptors.conservativeResize(3, Eigen::NoChange);
  EXPECT_EQ(localizer().Localize(query).reason, NotLocalizedReason::kTooFewFeatures);
}

TEST_F(LocalizerOnOneStreet, DoesNotLocalizeAnotherPlace) {
  StreetWorldOptions options;
  options.seed = 1234;  // Other landmarks with other looks.
  const StreetWorld elsewhere(options);
  const LocalizeResult result = localizer().Localize(QueryAt(elsewhere, QueryPose(20.0)));
  EXPECT_FALSE(result.localized);
}

TEST_F(LocalizerOnOneStreet, SaysTimeoutWhenTheDeadlineHasPassed) {
  LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  query.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  EXPECT_EQ(localizer().Localize(query).reason, NotLocalizedReason::kTimeout);
}

// Wherever in the query the deadline falls.
TEST_F(LocalizerOnOneStreet, AnswersByTheDeadlineOrSaysTimeout) {
  LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  const LocalizeResult unhurried = localizer().Localize(query);
  ASSERT_TRUE(unhurried.localized);
  for (int percent = 0; percent <= 120; percent += 5) {
    query.deadline = std::chrono::steady_clock::now() +
                     std::chrono::microseconds(
                         static_cast<int64_t>(1e4 * percent * unhurried.times.total_seconds));
    const LocalizeResult result = localizer().Localize(query);
    if (result.localized) {
      ExpectPose(result, *world_, QueryPose(20.0), 0.1, 0.005);
    } else {
      EXPECT_EQ(result.reason, NotLocalizedReason::kTimeout) << percent;
    }
  }
}

TEST_F(LocalizerOnOneStreet, AnswersProjectedFeaturesAsRawOnes) {
  const LocalizeQuery raw = QueryAt(*world_, QueryPose(20.0));
  LocalizeQuery projected = raw;
  const DescriptorCodec codec(map_->store().Snapshot().CurrentCodebook());
  projected.features.descriptors = codec.Project(raw.features.descriptors);
  projected.features.space = DescriptorSpace::kProjected;
  projected.codec = codec.codebook().CodecName();
  const LocalizeResult a = localizer().Localize(raw);
  const LocalizeResult b = localizer().Localize(projected);
  ASSERT_TRUE(a.localized);
  EXPECT_EQ(a.cam_from_anchor.ToMatrix(), b.cam_from_anchor.ToMatrix());
}

TEST_F(LocalizerOnOneStreet, RefusesDescriptorsThatAreNotTheMaps) {
  LocalizeQuery other_dim = QueryAt(*world_, QueryPose(20.0));
  other_dim.features.descriptors = DescriptorMatrix::Ones(other_dim.features.size(), 64);
  EXPECT_THROW(localizer().Localize(other_dim), Error);
  LocalizeQuery other_codec = QueryAt(*world_, QueryPose(20.0));
  other_codec.features.descriptors = DescriptorMatrix::Ones(other_codec.features.size(), 16);
  other_codec.features.space = DescriptorSpace::kProjected;
  other_codec.codec = "orb-32-16-1";
  EXPECT_THROW(localizer().Localize(other_codec), Error);
}

TEST_F(LocalizerOnOneStreet, GivesTheSameAnswerOnEveryThread) {
  const LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  const LocalizeResult expected = localizer().Localize(query);
  ASSERT_TRUE(expected.localized);
  std::vector<LocalizeResult> results(4);
  std::vector<std::thread> threads;
  for (LocalizeResult& result : results) {
    threads.emplace_back([&] { result = localizer().Localize(query); });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (const LocalizeResult& result : results) {
    ASSERT_TRUE(result.localized);
    EXPECT_EQ(result.cam_from_anchor.ToMatrix(), expected.cam_from_anchor.ToMatrix());
    EXPECT_EQ(result.covariance, expected.covariance);
  }
}

// The query with every n-th of its features, from the first on.
void KeepEvery(int n, LocalizeQuery* query) {
  FeatureSet& features = query->features;
  const int kept = (features.size() + n - 1) / n;
  for (int i = 0; i < kept; ++i) {
    features.keypoints[i] = features.keypoints[n * i];
    features.descriptors.row(i) = features.descriptors.row(n * i);
  }
  features.keypoints.resize(kept);
  features.descriptors.conservativeResize(kept, Eigen::NoChange);
}

// A rig of three cameras that see so little that none of them is localized alone.
LocalizeQuery PoorRigQuery(const StreetWorld& world, const Rigid3d& cam_from_enu) {
  constexpr int kThinning = 60;
  LocalizeQuery query = QueryAt(world, cam_from_enu);
  KeepEvery(kThinning, &query);
  for (const double azimuth_rad : {-0.5, 0.9}) {
    const Rigid3d own_from_enu = StreetWorld::LookAlong(
        cam_from_enu.Inverse().translation + Eigen::Vector3d(0.8, azimuth_rad, 0.2), azimuth_rad);
    LocalizeQuery own = QueryAt(world, own_from_enu);
    KeepEvery(kThinning, &own);
    query.other_cameras.push_back(
        {world.camera(), own_from_enu * cam_from_enu.Inverse(), own.features});
  }
  return query;
}

TEST_F(LocalizerOnOneStreet, LocalizesARigOfWhichNoCameraIsLocalizedAlone) {
  const Rigid3d cam_from_enu = QueryPose(20.0);
  for (const bool has_gravity : {true, false}) {
    LocalizeQuery rig = PoorRigQuery(*world_, cam_from_enu);
    LocalizeQuery alone = rig;
    alone.other_cameras.clear();
    EXPECT_FALSE(localizer().Localize(alone).localized);
    if (!has_gravity) {
      rig.down_in_cam.reset();
    }
    const LocalizeResult result = localizer().Localize(rig);
    ExpectPose(result, *world_, cam_from_enu, 0.1, 0.2 * kRadPerDeg);
    EXPECT_EQ(result.counters.num_keypoints, rig.num_features());
    std::set<int> cameras;
    for (const LocalizeMatch& match : result.matches) {
      cameras.insert(match.camera_idx);
      const FeatureSet& features =
          match.camera_idx == 0 ? rig.features : rig.other_cameras[match.camera_idx - 1].features;
      ASSERT_LT(match.keypoint_idx, features.size());
      EXPECT_EQ(match.pixel.x(), features.keypoints[match.keypoint_idx].x_px);
    }
    EXPECT_EQ(cameras.size(), 3u);
  }
}

TEST_F(LocalizerOnOneStreet, TheFirstCameraOfARigMaySeeNothing) {
  const Rigid3d cam_from_enu = QueryPose(20.0);
  LocalizeQuery rig = QueryAt(*world_, cam_from_enu);
  const Rigid3d own_from_first(ExpSo3({0.0, 0.4, 0.1}), {0.5, 0.0, -1.0});
  rig.other_cameras.push_back(
      {world_->camera(), own_from_first, QueryAt(*world_, own_from_first * cam_from_enu).features});
  rig.features = FeatureSet();
  ExpectPose(localizer().Localize(rig), *world_, cam_from_enu, 0.1, 0.2 * kRadPerDeg);
}

TEST_F(LocalizerOnOneStreet, RefusesRigsThatMakeNoSense) {
  LocalizeQuery query = PoorRigQuery(*world_, QueryPose(20.0));
  query.other_cameras[1].cam_from_first.translation.x() = 1000.0;
  EXPECT_THROW(localizer().Localize(query), Error);
  query = PoorRigQuery(*world_, QueryPose(20.0));
  query.other_cameras[0].features.space = DescriptorSpace::kProjected;
  EXPECT_THROW(localizer().Localize(query), Error);
  query = PoorRigQuery(*world_, QueryPose(20.0));
  query.other_cameras.resize(LocalizeQuery::kMaxOtherCameras + 1);
  EXPECT_THROW(localizer().Localize(query), Error);
}

TEST_F(LocalizerOnOneStreet, AnswerDoesNotDependOnTheNumberOfThreads) {
  for (const RefinementMode mode : {RefinementMode::kWhenWeak, RefinementMode::kAlways}) {
    for (const bool has_gravity : {true, false}) {
      LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
      if (!has_gravity) {
        query.down_in_cam.reset();
      }
      LocalizerOptions options;
      options.refinement.mode = mode;
      const LocalizeResult expected = map_->WithOptions(options).Localize(query);
      ASSERT_TRUE(expected.localized);
      for (const int num_threads : {2, 3, 7}) {
        options.num_threads = num_threads;
        const LocalizeResult result = map_->WithOptions(options).Localize(query);
        ASSERT_TRUE(result.localized);
        EXPECT_EQ(result.cam_from_anchor.ToMatrix(), expected.cam_from_anchor.ToMatrix());
        EXPECT_EQ(result.covariance, expected.covariance);
        EXPECT_EQ(result.score, expected.score);
        EXPECT_EQ(result.counters.num_votes, expected.counters.num_votes);
        EXPECT_EQ(result.counters.num_candidates, expected.counters.num_candidates);
        EXPECT_EQ(result.counters.num_ransac_iterations, expected.counters.num_ransac_iterations);
        EXPECT_EQ(result.counters.num_refined_keyframes, expected.counters.num_refined_keyframes);
        EXPECT_EQ(result.counters.num_rematches, expected.counters.num_rematches);
      }
    }
  }
}

TEST_F(LocalizerOnOneStreet, ConcurrentQueriesShareTheHelpers) {
  LocalizerOptions options;
  options.num_threads = 3;
  options.refinement.mode = RefinementMode::kAlways;
  const Localizer localizer = map_->WithOptions(options);
  const LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  const LocalizeResult expected = localizer.Localize(query);
  std::vector<LocalizeResult> results(4);
  std::vector<std::thread> threads;
  for (LocalizeResult& result : results) {
    threads.emplace_back([&] { result = localizer.Localize(query); });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (const LocalizeResult& result : results) {
    EXPECT_EQ(result.cam_from_anchor.ToMatrix(), expected.cam_from_anchor.ToMatrix());
  }
}

TEST(Localizer, SaysNoCoverageOnAnEmptyMap) {
  const StreetWorld world;
  const MappedStreets map({});
  LocalizeQuery query = QueryAt(world, QueryPose(20.0));
  EXPECT_EQ(map.localizer().Localize(query).reason, NotLocalizedReason::kNoCoverage);
  query.prior.reset();
  EXPECT_EQ(map.localizer().Localize(query).reason, NotLocalizedReason::kNoCoverage);
}

TEST(Localizer, SaysAmbiguousBetweenTwoEqualStreets) {
  StreetWorldOptions options;
  options.length_m = 20.0;
  options.num_landmarks = 600;
  const StreetWorld here(options);
  options.origin = GeodeticFromEcef(EcefFromEnu(options.origin) * Eigen::Vector3d(0.0, 30.0, 0.0));
  const StreetWorld same_again(options);
  const MappedStreets map({here, same_again});
  LocalizeQuery query = QueryAt(here, QueryPose(8.0));
  query.prior->accuracy_m = 40.0;
  const LocalizeResult result = map.localizer().Localize(query);
  EXPECT_FALSE(result.localized);
  EXPECT_EQ(result.reason, NotLocalizedReason::kAmbiguous);
}

// What became of queries along a street whose facades repeat.
struct RepeatedStreetTally {
  int num_right = 0, num_ambiguous = 0, num_wrong = 0, num_other = 0;
};

RepeatedStreetTally QueryRepeatedStreet(const StreetWorldOptions& options) {
  const StreetWorld world(options);
  const MappedStreets map({world});
  RepeatedStreetTally tally;
  for (double x_m = 2.0; x_m < options.length_m; x_m += 3.5) {
    const Rigid3d cam_from_enu = QueryPose(x_m);
    LocalizeQuery query = QueryAt(world, cam_from_enu);
    query.prior->accuracy_m = 40.0;
    const LocalizeResult result = map.localizer().Localize(query);
    if (!result.localized) {
      ++(result.reason == NotLocalizedReason::kAmbiguous ? tally.num_ambiguous : tally.num_other);
      continue;
    }
    const Rigid3d cam_from_ecef = cam_from_enu * EcefFromEnu(options.origin).Inverse();
    const double error_m =
        (result.cam_from_ecef.Inverse().translation - cam_from_ecef.Inverse().translation).norm();
    ++(error_m < 0.5 ? tally.num_right : tally.num_wrong);
  }
  return tally;
}

TEST(Localizer, SaysAmbiguousWhereFacadesRepeat) {
  StreetWorldOptions options;
  options.length_m = 100.0;
  options.num_landmarks = 3000;
  for (const double period_m : {20.0, 40.0}) {
    options.repeat_period_m = period_m;
    const RepeatedStreetTally tally = QueryRepeatedStreet(options);
    EXPECT_EQ(tally.num_wrong, 0) << period_m;
    EXPECT_GE(tally.num_ambiguous, 15) << period_m;
  }
}

TEST(Localizer, TellsRepeatedFacadesApartByWhatIsUnique) {
  StreetWorldOptions options;
  options.length_m = 100.0;
  options.num_landmarks = 3000;
  options.repeat_period_m = 25.0;
  options.unique_ratio = 0.5;
  const RepeatedStreetTally tally = QueryRepeatedStreet(options);
  EXPECT_EQ(tally.num_wrong, 0);
  EXPECT_GE(tally.num_right, 22);  // Of 28; none if effective inliers alone had to tell.
}

// A street whose first camera stands `west_m` west and `south_m` south of the north-east corner of
// a tile.
StreetWorldOptions StreetNearCorner(double west_m, double south_m) {
  StreetWorldOptions options;
  options.num_landmarks = 2000;
  const Geodetic corner = TileId::Containing(options.origin).Corners()[2];
  options.origin = GeodeticFromEcef(EcefFromEnu({corner.lat_rad, corner.lon_rad, 408.0}) *
                                    Eigen::Vector3d(-west_m, -south_m, 0.0));
  return options;
}

// Asks along the street with priors of 5, 20 and 50 m that are off by about as much as they say.
void ExpectAnswersForEveryPrior(const StreetWorld& world, size_t min_tiles) {
  const MappedStreets map({world});
  size_t most_tiles = 0;
  int i = 0;
  for (const double accuracy_m : {5.0, 20.0, 50.0}) {
    for (const double x_m : {10.0, 19.0, 21.0, 34.0, 50.0}) {
      const Rigid3d cam_from_enu = QueryPose(x_m);
      LocalizeQuery query = QueryAt(world, cam_from_enu);
      const double angle_rad = 2.4 * i++;
      const Eigen::Vector3d offset =
          accuracy_m * Eigen::Vector3d(std::cos(angle_rad), std::sin(angle_rad), 0.0);
      query.prior->position = GeodeticFromEcef(EcefFromEnu(world.options().origin) *
                                               (cam_from_enu.Inverse().translation + offset));
      query.prior->accuracy_m = accuracy_m;
      const LocalizeResult result = map.localizer().Localize(query);
      SCOPED_TRACE(accuracy_m);
      SCOPED_TRACE(x_m);
      ExpectPose(result, world, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
      most_tiles = std::max(most_tiles, result.tiles.size());
    }
  }
  EXPECT_GE(most_tiles, min_tiles);
}

TEST(Localizer, AnswersAcrossATileBorderForEveryPrior) {
  ExpectAnswersForEveryPrior(StreetWorld(StreetNearCorner(20.0, 75.0)), 2);
}

TEST(Localizer, AnswersAcrossATileCornerForEveryPrior) {
  ExpectAnswersForEveryPrior(StreetWorld(StreetNearCorner(20.0, 0.0)), 4);
}

TEST(Localizer, AnswersAcrossAZoneBorderForEveryPrior) {
  StreetWorldOptions options;
  options.origin = Geodetic::FromDegrees(47.0, 11.99974, 600.0);  // 20 m west of zone 33.
  options.num_landmarks = 2000;
  ExpectAnswersForEveryPrior(StreetWorld(options), 2);
}

TEST(Localizer, AnswersBesideATileThatIsMissing) {
  // One street through three tiles, of which the middle one was never mapped.
  StreetWorldOptions west = StreetNearCorner(60.0, 75.0), east = west;
  west.length_m = 55.0;
  west.num_landmarks = 1500;
  east.start_m = 60.0 + TileId::kSideM + 5.0;
  east.length_m = 55.0;
  east.num_landmarks = 1500;
  east.seed = 77;
  const StreetWorld west_world(west), east_world(east);
  const MappedStreets map({west_world, east_world});
  const auto ask = [&map](const StreetWorld& world, double x_m) {
    LocalizeQuery query = QueryAt(world, QueryPose(x_m));
    query.prior->accuracy_m = 50.0;
    return map.localizer().Localize(query);
  };
  for (const double x_m : {20.0, 50.0}) {
    ExpectPose(ask(west_world, x_m), west_world, QueryPose(x_m), 0.05, 0.1 * kRadPerDeg);
  }
  const double in_east_m = east.start_m + 20.0;
  ExpectPose(ask(east_world, in_east_m), east_world, QueryPose(in_east_m), 0.05, 0.1 * kRadPerDeg);
  // In the gap between the two, with both in reach: a miss with its reason.
  StreetWorldOptions unmapped = west;
  unmapped.seed = 5;
  unmapped.start_m = 100.0;
  const StreetWorld gap_world(unmapped);
  LocalizeQuery lost = QueryAt(gap_world, QueryPose(130.0));
  lost.prior->accuracy_m = 80.0;
  const LocalizeResult result = map.localizer().Localize(lost);
  EXPECT_FALSE(result.localized);
  EXPECT_EQ(result.counters.num_tiles_searched, 2);
  EXPECT_THAT(result.reason,
              AnyOf(NotLocalizedReason::kTooFewMatches, NotLocalizedReason::kTooFewInliers));
}

TEST(Localizer, WorksAcrossAZoneBorder) {
  StreetWorldOptions options;
  options.origin = Geodetic::FromDegrees(47.0, 11.9996, 600.0);  // 30 m west of zone 33.
  const StreetWorld world(options);
  const MappedStreets map({world});
  const Rigid3d cam_from_enu = QueryPose(29.0);
  const LocalizeResult result = map.localizer().Localize(QueryAt(world, cam_from_enu));
  ExpectPose(result, world, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
  ASSERT_GE(result.tiles.size(), 2u);
  EXPECT_NE(result.tiles.front().zone(), result.tiles.back().zone());
}

TEST(Localizer, SeesAnUpdateOfTheMap) {
  StreetWorldOptions options;
  options.length_m = 30.0;
  options.num_landmarks = 600;
  const StreetWorld first(options);
  options.seed = 7;
  options.origin = GeodeticFromEcef(EcefFromEnu(options.origin) * Eigen::Vector3d(0.0, 500.0, 0.0));
  const StreetWorld second(options);
  MappedStreets map({first});
  const LocalizeQuery query = QueryAt(second, QueryPose(12.0));
  EXPECT_EQ(map.localizer().Localize(query).reason, NotLocalizedReason::kNoCoverage);
  map.Add(second);
  EXPECT_TRUE(map.localizer().Localize(query).localized);
}

TEST(Localizer, RefusesOptionsThatMakeNoSense) {
  LocalizerOptions options;
  options.answer.ambiguous_score_ratio = 2.0;
  EXPECT_THROW(MappedStreets({}, options), Error);
}

}  // namespace
}  // namespace cairn
