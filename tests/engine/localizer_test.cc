#include "engine/localizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/angles.h"
#include "core/error.h"
#include "engine/mapped_streets.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

using testing::ExpectPose;
using testing::ExpectSameAnswer;
using testing::MappedStreets;
using testing::QueryAt;
using testing::QueryPose;
using testing::StreetWorld;
using testing::StreetWorldOptions;

class LocalizerOnOneStreet : public testing::OneStreetTest {};

TEST_F(LocalizerOnOneStreet, FindsPosesBetweenTheKeyframes) {
  for (const double x_m : {4.0, 17.5, 31.0, 44.5}) {
    const Rigid3d cam_from_enu = QueryPose(x_m);
    ExpectPose(localizer().Localize(QueryAt(*world_, cam_from_enu)), *world_, cam_from_enu, 0.05,
               0.1 * kRadPerDeg);
  }
}

// Who asks for refinement in any case gets all keypoints searched.
TEST_F(LocalizerOnOneStreet, ASureQuerySearchesAFewOfItsKeypoints) {
  const Rigid3d cam_from_enu = QueryPose(20.0);
  const LocalizeQuery query = QueryAt(*world_, cam_from_enu);
  ASSERT_GT(query.num_features(), 256);
  LocalizerOptions all_options;
  all_options.refinement.mode = RefinementMode::kAlways;
  const LocalizeResult few = localizer().Localize(query);
  const LocalizeResult all = map_->WithOptions(all_options).Localize(query);
  ExpectPose(few, *world_, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
  ExpectPose(all, *world_, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
  EXPECT_LT(few.counters.num_matches, all.counters.num_matches / 2);
  // The pose predicts the others.
  EXPECT_GT(few.matches.size(), 0.9 * all.matches.size());
}

TEST_F(LocalizerOnOneStreet, WorksWithEveryAlternative) {
  std::vector<LocalizerOptions> alternatives;
  for (const IndexKind kind : {IndexKind::kInvertedLists, IndexKind::kExhaustive}) {
    alternatives.emplace_back().matching.index.kind = kind;
  }
  alternatives.emplace_back().voting.filter = OutlierFilter::kVoting3d;
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
  options.refinement.good_evidence = 1e6;
  EXPECT_EQ(map_->WithOptions(options).Localize(query).counters.num_refined_keyframes, 0);
  options.refinement.mode = RefinementMode::kWhenWeak;
  EXPECT_GT(map_->WithOptions(options).Localize(query).counters.num_refined_keyframes, 0);
}

// If no keyframe ranks by matches, the keyframes that see the inliers of the best poses are used.
TEST_F(LocalizerOnOneStreet, RefinesWhereItsBestPosesAre) {
  const Rigid3d cam_from_enu = QueryPose(20.0);
  const LocalizeQuery query = QueryAt(*world_, cam_from_enu);
  LocalizerOptions options;
  options.refinement.mode = RefinementMode::kAlways;
  options.refinement.max_keyframes = 0;
  options.refinement.max_pose_keyframes = 1;
  const LocalizeResult result = map_->WithOptions(options).Localize(query);
  ExpectPose(result, *world_, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
  EXPECT_EQ(result.counters.num_refined_keyframes, 1);
  EXPECT_GT(result.counters.num_rematches, 0);
  options.refinement.max_pose_keyframes = 0;
  EXPECT_EQ(map_->WithOptions(options).Localize(query).counters.num_refined_keyframes, 0);
}

// Neither of the strict matches nor of those with a single keyframe alone.
TEST_F(LocalizerOnOneStreet, RefinesTheAnswerOnAllMatches) {
  const Rigid3d cam_from_enu = QueryPose(20.0);
  const LocalizeQuery query = QueryAt(*world_, cam_from_enu);
  LocalizerOptions options;
  options.refinement.good_evidence = 1e6;  // A sure pose would predict all of its matches.
  options.refinement.mode = RefinementMode::kNever;
  const LocalizeResult plain = map_->WithOptions(options).Localize(query);
  options.refinement.mode = RefinementMode::kAlways;
  options.refinement.max_keyframes = 1;
  options.refinement.max_pose_keyframes = 0;
  options.refinement.neighbors_per_keyframe = 0;
  const LocalizeResult refined = map_->WithOptions(options).Localize(query);
  ExpectPose(refined, *world_, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
  EXPECT_GT(refined.matches.size(), plain.matches.size());
  EXPECT_GT(refined.matches.size(), static_cast<size_t>(refined.counters.num_rematches));
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
    EXPECT_NEAR((*pixel - match.pixel).norm(), match.traits.error_px, 1e-9);
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

TEST_F(LocalizerOnOneStreet, DoubtsGravityThatLeadsNowhere) {
  const Rigid3d cam_from_enu = QueryPose(20.0);
  LocalizeQuery query = QueryAt(*world_, cam_from_enu);
  *query.down_in_cam *= -1.0;
  const LocalizeResult result = localizer().Localize(query);
  ExpectPose(result, *world_, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
  EXPECT_FALSE(result.counters.used_gravity);

  LocalizerOptions trusting;
  trusting.refinement.mode = RefinementMode::kNever;
  const LocalizeResult lost = map_->WithOptions(trusting).Localize(query);
  EXPECT_EQ(lost.reason, NotLocalizedReason::kTooFewInliers);
  EXPECT_TRUE(lost.counters.used_gravity);
}

TEST_F(LocalizerOnOneStreet, DoubtsGravityThatAWeakAnswerIsTiltedAgainst) {
  const Rigid3d cam_from_enu = QueryPose(20.0);
  LocalizeQuery query = QueryAt(*world_, cam_from_enu);
  LocalizerOptions options;
  options.refinement.good_evidence = 1e6;  // Every answer is weak.
  const auto num_distances = [&](double tilt_rad, double max_error_sigmas) {
    options.refinement.max_gravity_error_sigmas = max_error_sigmas;
    LocalizeQuery tilted = query;
    tilted.down_in_cam = Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitZ()) * *query.down_in_cam;
    const LocalizeResult result = map_->WithOptions(options).Localize(tilted);
    ExpectPose(result, *world_, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
    return result.counters.num_distances;
  };
  const double sigma_rad = options.pose.gravity_sigma_rad;
  constexpr double kNoLimit = std::numeric_limits<double>::infinity();
  // Matching is done twice if gravity is doubted.
  EXPECT_EQ(num_distances(0.0, 4.0), num_distances(0.0, kNoLimit));
  EXPECT_GT(num_distances(5.0 * sigma_rad, 4.0), num_distances(5.0 * sigma_rad, kNoLimit));
  EXPECT_EQ(num_distances(3.0 * sigma_rad, 4.0), num_distances(3.0 * sigma_rad, kNoLimit));
}

TEST_F(LocalizerOnOneStreet, DoubtsGravityIfTheAnswerHasLittleEvidence) {
  const Rigid3d cam_from_enu = QueryPose(20.0);
  const LocalizeQuery query = QueryAt(*world_, cam_from_enu);
  LocalizerOptions options;
  const auto num_distances = [&](double min_trusted) {
    options.refinement.min_trusted_evidence = min_trusted;
    const LocalizeResult result = map_->WithOptions(options).Localize(query);
    ExpectPose(result, *world_, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
    return result.counters.num_distances;
  };
  EXPECT_GT(num_distances(1e6), num_distances(0.0));
}

// The poses that are tried without gravity lose to one that was found with it.
TEST_F(LocalizerOnOneStreet, APoseFoundWithGravityIsRefinedWithIt) {
  const Rigid3d cam_from_enu = QueryPose(20.0);
  LocalizerOptions options;
  options.refinement.min_trusted_evidence = 1e6;
  const LocalizeResult result = map_->WithOptions(options).Localize(QueryAt(*world_, cam_from_enu));
  ExpectPose(result, *world_, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
  EXPECT_TRUE(result.counters.used_gravity);
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

TEST_F(LocalizerOnOneStreet, AnswersFarFromThePriorAndSaysSo) {
  const Rigid3d cam_from_enu = QueryPose(50.0);
  LocalizeQuery query = QueryAt(*world_, cam_from_enu);
  EXPECT_FALSE(localizer().Localize(query).prior_disagrees);
  query.prior->position =
      GeodeticFromEcef(EcefFromEnu(world_->options().origin) * Eigen::Vector3d(20.0, 0.0, 1.6));
  query.prior->accuracy_m = 5.0;
  const LocalizeResult result = localizer().Localize(query);
  ExpectPose(result, *world_, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
  EXPECT_TRUE(result.prior_disagrees);
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

// The first of them find no tile in the cache. Inverted lists search a tile before it is decoded.
TEST_F(LocalizerOnOneStreet, ConcurrentQueriesShareTilesAndHelpers) {
  LocalizerOptions options;
  options.num_threads = 3;
  options.refinement.mode = RefinementMode::kAlways;
  const LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  for (const IndexKind kind : {IndexKind::kRandomGrids, IndexKind::kInvertedLists}) {
    options.matching.index.kind = kind;
    const LocalizeResult expected = map_->WithOptions(options).Localize(query);
    const Localizer localizer = map_->WithOptions(options);
    std::vector<LocalizeResult> results(8);
    std::vector<std::thread> threads;
    for (size_t i = 0; i < 4; ++i) {
      threads.emplace_back([&, i] {
        results[2 * i] = localizer.Localize(query);
        results[2 * i + 1] = localizer.Localize(query);
      });
    }
    for (std::thread& thread : threads) {
      thread.join();
    }
    for (const LocalizeResult& result : results) {
      ExpectSameAnswer(result, expected);
    }
  }
}

}  // namespace
}  // namespace cairn
