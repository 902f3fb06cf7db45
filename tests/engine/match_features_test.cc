#include "engine/matching/match_features.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <map>
#include <random>
#include <utility>

#include "core/angles.h"
#include "core/error.h"
#include "engine/index_under_test.h"
#include "engine/landmark_matches.h"
#include "engine/simple_tile.h"
#include "engine/synthetic_descriptors.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::kDistanceTolerance;
using testing::LandmarkIds;
using testing::Match;
using testing::SimpleDescriptor;
using testing::SimpleLandmark;
using testing::SimpleQuery;
using testing::SimpleTile;
using testing::SimpleView;

MatchingOptions NoTerms() { return {.orientation_weight = 0.0, .position_weight = 0.0}; }

TEST(MatchFeatures, ReturnsTheNearestLandmarksNearestFirst) {
  const std::vector<TileView> tiles = {SimpleView(
      SimpleTile({{1, {{0.9f}}}, {2, {{0.1f}}}, {3, {{0.5f}}}, {4, {{0.3f}}}, {5, {{0.7f}}}}))};
  MatchingOptions options;
  options.max_neighbors = 3;
  const auto matches = Match(SimpleQuery({{0.0f}}), tiles, options);
  EXPECT_THAT(LandmarkIds(tiles, matches), ElementsAre(2, 4, 3));
  EXPECT_NEAR(matches[2].sq_distance, 0.25f, kDistanceTolerance);
}

TEST(MatchFeatures, OrdersByKeypointAndFillsEveryField) {
  const Rigid3d anchor_from_tile(Eigen::Quaterniond::Identity(), {100.0, 200.0, 3.0});
  const std::vector<TileView> tiles = {
      SimpleView(SimpleTile({{1, {{0.2f}}, {1.0, 2.0, 3.0}}, {2, {{1.2f}}, {4.0, 5.0, 6.0}}}),
                 anchor_from_tile)};
  MatchingOptions options;
  options.max_neighbors = 1;
  const auto matches = Match(SimpleQuery({{1.2f}, {0.2f}}), tiles, options);
  ASSERT_EQ(matches.size(), 2u);
  EXPECT_EQ(matches[0].keypoint_idx, 0);
  EXPECT_EQ(matches[0].landmark_idx, 1u);
  EXPECT_EQ(matches[0].tile_idx, 0);
  EXPECT_EQ(matches[0].x_in_anchor, Eigen::Vector3d(104.0, 205.0, 9.0));
  EXPECT_NEAR(matches[0].sigma_m, 0.05, 0.0025);
  EXPECT_NEAR(matches[0].size_m, 0.1, 0.01);  // Half a step of the codes, as below.
  EXPECT_NEAR(matches[0].azimuth_rad, 1.0, 0.1);
  EXPECT_EQ(matches[1].keypoint_idx, 1);
  EXPECT_EQ(matches[1].landmark_idx, 0u);
}

TEST(MatchFeatures, ALandmarkCountsOnceByItsNearestDescriptor) {
  const std::vector<TileView> tiles = {
      SimpleView(SimpleTile({{1, {{0.6f}, {0.1f}, {0.4f}}}, {2, {{0.3f}, {0.3f}}}}))};
  const auto matches = Match(SimpleQuery({{0.0f}}), tiles, NoTerms());
  EXPECT_THAT(LandmarkIds(tiles, matches), ElementsAre(1, 2));
  EXPECT_NEAR(matches[0].sq_distance, 0.01f, kDistanceTolerance);
}

TEST(MatchFeatures, ALandmarkInSeveralTilesCountsOnceByItsNearestCopy) {
  const std::vector<TileView> tiles = {SimpleView(SimpleTile({{7, {{0.5f}}}, {8, {{0.2f}}}})),
                                       SimpleView(SimpleTile({{6, {{0.3f}}}, {7, {{0.1f}}}})),
                                       SimpleView(SimpleTile({{7, {{0.4f}}}}))};
  const auto matches = Match(SimpleQuery({{0.0f}}), tiles, NoTerms());
  EXPECT_THAT(LandmarkIds(tiles, matches), ElementsAre(7, 8, 6));
  EXPECT_EQ(matches[0].tile_idx, 1);
}

TEST(MatchFeatures, EvictedLandmarkReturnsByANearerCopy) {
  MatchingOptions options = NoTerms();
  options.max_neighbors = 1;
  const std::vector<TileView> tiles = {SimpleView(SimpleTile({{1, {{0.5f}}}, {2, {{0.3f}}}})),
                                       SimpleView(SimpleTile({{1, {{0.1f}}}}))};
  EXPECT_THAT(LandmarkIds(tiles, Match(SimpleQuery({{0.0f}}), tiles, options)), ElementsAre(1));
}

TEST(MatchFeatures, EqualDistancesAreOrderedByLandmark) {
  const std::vector<TileView> tiles = {
      SimpleView(SimpleTile({{9, {{0.2f}}}, {4, {{0.2f}}}, {6, {{0.2f}}}}))};
  MatchingOptions options = NoTerms();
  options.max_neighbors = 2;
  EXPECT_THAT(LandmarkIds(tiles, Match(SimpleQuery({{0.0f}}), tiles, options)), ElementsAre(4, 6));
}

std::vector<int> Keypoints(const std::vector<Correspondence>& matches) {
  std::vector<int> keypoints;
  for (const Correspondence& match : matches) {
    keypoints.push_back(match.keypoint_idx);
  }
  return keypoints;
}

TEST(MatchFeatures, ALandmarkKeepsItsNearestKeypoints) {
  MatchingOptions options = NoTerms();
  options.max_keypoints_of_landmark = 2;
  const std::vector<TileView> tiles = {SimpleView(SimpleTile({{1, {{0.0f}}}, {2, {{1.0f}}}})),
                                       SimpleView(SimpleTile({{1, {{0.01f}}}}))};
  const auto matches =
      Match(SimpleQuery({{0.2f}, {0.9f}, {0.1f}, {0.25f}, {0.05f}}), tiles, options);
  EXPECT_THAT(Keypoints(matches), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(LandmarkIds(tiles, matches), ElementsAre(2, 1, 2, 1));
}

TEST(MatchFeatures, ALandmarkKeepsTheFirstOfEquallyNearKeypoints) {
  MatchingOptions options = NoTerms();
  options.max_keypoints_of_landmark = 2;
  const std::vector<TileView> tiles = {SimpleView(SimpleTile({{1, {{0.0f}}}}))};
  EXPECT_THAT(Keypoints(Match(SimpleQuery({{0.1f}, {0.1f}, {0.1f}}), tiles, options)),
              ElementsAre(0, 1));
}

TEST(MatchFeatures, NothingBeyondTheThresholdMatches) {
  const std::vector<TileView> tiles = {SimpleView(SimpleTile({{1, {{0.4f}}}, {2, {{0.6f}}}}))};
  MatchingOptions options;
  options.distance_quantile = 0.25;  // Distance 0.5.
  EXPECT_THAT(LandmarkIds(tiles, Match(SimpleQuery({{0.0f}}), tiles, options)), ElementsAre(1));
}

TEST(MatchFeatures, WithoutAThresholdTheNearestMatchHoweverFar) {
  const std::vector<TileView> tiles = {
      SimpleView(SimpleTile({{1, {{0.9f}}}, {2, {{1.5f}}}, {3, {{1.1f}}}}))};
  MatchingOptions options;
  options.distance_quantile = 0.05;  // Distance 0.1.
  options.max_neighbors = 2;
  EXPECT_THAT(Match(SimpleQuery({{0.0f}}), tiles, options), IsEmpty());
  options.distance_filter = DistanceFilter::kNone;
  EXPECT_THAT(LandmarkIds(tiles, Match(SimpleQuery({{0.0f}}), tiles, options)), ElementsAre(1, 3));
}

TEST(MatchFeatures, WithoutAThresholdALandmarkOfManyDescriptorsHidesNoOther) {
  SimpleLandmark crowded = {1, {}};
  crowded.descriptors.resize(60, {0.2f});
  const std::vector<TileView> tiles = {SimpleView(SimpleTile({crowded, {2, {{0.9f}}}}))};
  MatchingOptions options;
  options.distance_filter = DistanceFilter::kNone;
  EXPECT_THAT(LandmarkIds(tiles, Match(SimpleQuery({{0.0f}}), tiles, options)), ElementsAre(1, 2));
}

// A dense cloud of landmarks about 0.15 and a single one at 1.2.
std::vector<TileView> UnevenTile() {
  std::vector<SimpleLandmark> landmarks;
  for (uint64_t id = 1; id <= 20; ++id) {
    landmarks.push_back({id, {{id % 2 == 0 ? 0.1f : 0.2f}}});
  }
  landmarks.push_back({21, {{1.2f}}});
  IndexOptions index = testing::ExhaustiveGrids();
  index.num_reference_words = 100;
  return {SimpleView(SimpleTile(landmarks), Rigid3d(), index)};
}

TEST(MatchFeatures, WordRatioComparesWithTheNearestWord) {
  // As many words as descriptors: every descriptor is a word.
  const std::vector<TileView> tiles = UnevenTile();
  MatchingOptions options;
  options.max_neighbors = 64;
  options.index.num_reference_words = 100;
  options.distance_filter = DistanceFilter::kWordRatio;
  options.max_word_ratio = 1.1;
  // Words at 0.4 from 0.6 and 0.6 from 1.2.
  EXPECT_EQ(Match(SimpleQuery({{0.6f}}), tiles, options).size(), 10u);  // Those at 0.2.
  options.max_word_ratio = 1.3;
  EXPECT_EQ(Match(SimpleQuery({{0.6f}}), tiles, options).size(), 20u);
  options.max_word_ratio = 0.9;
  EXPECT_THAT(Match(SimpleQuery({{0.6f}}), tiles, options), IsEmpty());
}

TEST(MatchFeatures, EveryKindOfIndexGivesTheSameMatches) {
  const Tile tile =
      SimpleTile({{1, {{0.9f}, {0.3f}}}, {2, {{0.1f}}}, {3, {{0.5f}}}, {4, {{1.4f}}}});
  const QueryContext query = SimpleQuery({{0.0f}, {1.0f}});
  MatchingOptions options;
  options.max_neighbors = 2;
  IndexOptions lists, exhaustive;
  lists.kind = IndexKind::kInvertedLists;
  exhaustive.kind = IndexKind::kExhaustive;
  for (const IndexOptions& index :
       {testing::ExhaustiveGrids(), lists, exhaustive, testing::OtherIndex()}) {
    const std::vector<TileView> tiles = {SimpleView(tile, Rigid3d(), index)};
    EXPECT_THAT(LandmarkIds(tiles, Match(query, tiles, options)), ElementsAre(2, 1, 1, 4))
        << static_cast<int>(index.kind);
  }
}

// Landmarks at random places with random descriptors; some are in several tiles.
std::vector<SimpleLandmark> RandomLandmarks(std::mt19937_64* random, int count) {
  const auto uniform = [random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(*random);
  };
  std::vector<SimpleLandmark> landmarks;
  for (int i = 0; i < count; ++i) {
    SimpleLandmark landmark = {.id = (*random)() % 300,
                               .x_in_tile = {uniform(-70, 70), uniform(-70, 70), 0.0}};
    for (uint64_t j = 0; j < 1 + (*random)() % 4; ++j) {
      landmark.descriptors.push_back({0.1f * static_cast<float>((*random)() % 16), std::nullopt});
      if ((*random)() % 5 != 0) {
        landmark.descriptors.back().orientation_rad = uniform(-kPi, kPi);
      }
    }
    landmarks.push_back(landmark);
  }
  return landmarks;
}

// Hits wait in rings and bounds fall while the search runs; nothing may get lost on the way.
TEST(MatchFeatures, KeepsTheBestOfAllHitsOfAllTiles) {
  std::mt19937_64 random(1);
  std::vector<TileView> tiles;
  for (int tile = 0; tile < 3; ++tile) {
    tiles.push_back(SimpleView(SimpleTile(RandomLandmarks(&random, 150))));
  }
  QueryContext query = SimpleQuery({{0.0f, 1.0}, {0.7f, -2.0}, {1.5f, std::nullopt}, {0.3f, 3.0}});
  query.region.has_prior = true;
  query.region.prior_sigma_m = 10.0;
  const MatchingOptions options = {.max_neighbors = 5,
                                   .orientation_weight = 0.2,
                                   .position_weight = 0.1,
                                   .viewing_distance_m = 20.0};
  const auto matches = Match(query, tiles, options);

  using Ranked = std::pair<float, uint64_t>;
  std::vector<Ranked> expected;
  for (int keypoint = 0; keypoint < query.num_keypoints(); ++keypoint) {
    std::map<uint64_t, float> best_of_landmark;
    for (const TileView& view : tiles) {
      const TileLandmarks& tile = view.tile->landmarks();
      const DescriptorPlaces places(tile, {});
      std::vector<DescriptorHit> hits;
      ByteDescriptors(view.tile->codebook(), view.tile->codes())
          .RangeSearch(query.descriptors.row(keypoint), 1.8, &hits);
      for (const DescriptorHit& hit : hits) {
        const uint32_t landmark = places.landmark(hit.descriptor_idx);
        double sq_distance = hit.sq_distance;
        const uint8_t code = tile.orientation_codes[hit.descriptor_idx];
        if (code != kNoOrientation && query.gravity_orientations_rad[keypoint]) {
          sq_distance += 0.2 * (2.0 - 2.0 * std::cos(OrientationFromCode(code) -
                                                     *query.gravity_orientations_rad[keypoint]));
        }
        const double excess =
            std::max(0.0, tile.x_in_tile[landmark].head<2>().cast<double>().norm() - 20.0) / 10.0;
        sq_distance += 0.1 * excess * excess;
        const auto [entry, is_new] = best_of_landmark.try_emplace(
            Value(tile.landmark_ids[landmark]), static_cast<float>(sq_distance));
        entry->second = std::min(entry->second, static_cast<float>(sq_distance));
      }
    }
    std::vector<Ranked> ranked;
    for (const auto& [id, sq_distance] : best_of_landmark) {
      ranked.emplace_back(sq_distance, id);
    }
    std::sort(ranked.begin(), ranked.end());
    expected.insert(expected.end(), ranked.begin(), ranked.begin() + 5);
  }
  ASSERT_EQ(matches.size(), expected.size());
  for (size_t i = 0; i < matches.size(); ++i) {
    EXPECT_NEAR(matches[i].sq_distance, expected[i].first, 1e-4);
  }
  EXPECT_EQ(LandmarkIds(tiles, matches).front(), expected.front().second);
}

TEST(MatchFeatures, FewerLandmarksThanNeighborsGiveAllOfThem) {
  const std::vector<TileView> tiles = {SimpleView(SimpleTile({{1, {{0.4f}}}, {2, {{0.6f}}}}))};
  MatchingOptions options;
  options.max_neighbors = 64;
  EXPECT_EQ(Match(SimpleQuery({{0.0f}}), tiles, options).size(), 2u);
}

TEST(MatchFeatures, EmptyTilesAndNoTilesGiveNoMatches) {
  EXPECT_THAT(Match(SimpleQuery({{0.0f}}), {}), IsEmpty());
  EXPECT_THAT(Match(SimpleQuery({{0.0f}}), {SimpleView(SimpleTile({}))}), IsEmpty());
  EXPECT_THAT(Match(SimpleQuery({}), {SimpleView(SimpleTile({{1, {{0.4f}}}}))}), IsEmpty());
}

TEST(MatchFeatures, CountsMatchesAndDistances) {
  const std::vector<TileView> tiles = {SimpleView(SimpleTile({{1, {{0.1f}}}, {2, {{0.3f}}}})),
                                       SimpleView(SimpleTile({{3, {{1.5f}, {1.5f}}}}))};
  MatchingOptions options;
  options.distance_quantile = 0.25;
  const FeatureMatches matches =
      MatchFeatures(SimpleQuery({{0.0f}, {1.5f}, {0.9f}}), tiles, options);
  EXPECT_EQ(matches.num_distances, 3 * 4);
  EXPECT_EQ(matches.correspondences.size(), 3u);
  EXPECT_EQ(matches.num_matched_keypoints, 2);
}

TEST(MatchFeatures, ThreadsChangeNothing) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> anywhere(-1.5f, 1.5f);
  std::vector<TileView> tiles;
  for (uint64_t tile = 0; tile < 3; ++tile) {
    std::vector<SimpleLandmark> landmarks;
    for (uint64_t i = 0; i < 500; ++i) {
      landmarks.push_back({300 * tile + i + 1, {{anywhere(random)}, {anywhere(random)}}});
    }
    tiles.push_back(SimpleView(SimpleTile(landmarks)));
  }
  std::vector<SimpleDescriptor> keypoints(1000);
  for (SimpleDescriptor& keypoint : keypoints) {
    keypoint = {anywhere(random)};
  }
  const QueryContext query = SimpleQuery(keypoints);
  for (const int max_keypoints_of_landmark : {8, 1000}) {
    const MatchingOptions options = {.max_keypoints_of_landmark = max_keypoints_of_landmark};
    const FeatureMatches alone = MatchFeatures(query, tiles, options);
    const std::vector<Correspondence>& expected = alone.correspondences;
    ASSERT_GT(expected.size(), max_keypoints_of_landmark == 8 ? 100u : 1000u);
    for (const int num_threads : {2, 3, 7}) {
      SharedWorkers workers(num_threads);
      const FeatureMatches shared = MatchFeatures(query, tiles, options, &workers);
      const std::vector<Correspondence>& matches = shared.correspondences;
      EXPECT_EQ(shared.num_distances, alone.num_distances);
      ASSERT_EQ(matches.size(), expected.size());
      for (size_t i = 0; i < matches.size(); ++i) {
        EXPECT_EQ(matches[i].keypoint_idx, expected[i].keypoint_idx);
        EXPECT_EQ(matches[i].tile_idx, expected[i].tile_idx);
        EXPECT_EQ(matches[i].landmark_idx, expected[i].landmark_idx);
        EXPECT_EQ(matches[i].sq_distance, expected[i].sq_distance);
      }
    }
  }
}

// The largest keypoints come first, and the last round ends where one round over all would have.
TEST(FeatureMatcher, ARoundAddsToTheMatchesOfTheLast) {
  constexpr int kNumKeypoints = 300, kFirst = 100;
  std::mt19937 random(2);
  std::uniform_real_distribution<float> anywhere(0.0f, 1.5f);
  std::vector<SimpleLandmark> landmarks;
  for (uint64_t i = 0; i < 400; ++i) {
    landmarks.push_back({i + 1, {{anywhere(random)}}});
  }
  const std::vector<TileView> tiles = {SimpleView(SimpleTile(landmarks))};
  std::vector<SimpleDescriptor> descriptors(kNumKeypoints);
  for (SimpleDescriptor& descriptor : descriptors) {
    descriptor = {anywhere(random)};
  }
  QueryContext query = SimpleQuery(descriptors);
  for (Keypoint& keypoint : query.keypoints) {
    keypoint.scale_px = 1.0f + 10.0f * anywhere(random);
  }
  std::vector<float> scales;
  for (const Keypoint& keypoint : query.keypoints) {
    scales.push_back(keypoint.scale_px);
  }
  std::nth_element(scales.begin(), scales.end() - kFirst, scales.end());
  const float least_px = *(scales.end() - kFirst);
  const MatchingOptions options = {.max_keypoints_of_landmark = kNumKeypoints};
  const FeatureMatches all = MatchFeatures(query, tiles, options);
  const auto expect_same = [](const std::vector<Correspondence>& a,
                              const std::vector<Correspondence>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].keypoint_idx, b[i].keypoint_idx);
      EXPECT_EQ(a[i].landmark_idx, b[i].landmark_idx);
      EXPECT_EQ(a[i].sq_distance, b[i].sq_distance);
    }
  };
  std::vector<Correspondence> of_large;
  std::copy_if(
      all.correspondences.begin(), all.correspondences.end(), std::back_inserter(of_large),
      [&](const auto& match) { return query.keypoints[match.keypoint_idx].scale_px >= least_px; });
  ASSERT_GT(of_large.size(), 0u);
  FeatureMatcher matcher(query, tiles, options);
  const FeatureMatches first = matcher.MatchUpTo(kFirst, nullptr, {});
  expect_same(first.correspondences, of_large);
  EXPECT_LT(first.num_distances, all.num_distances);
  const FeatureMatches last = matcher.MatchUpTo(kNumKeypoints, nullptr, {});
  expect_same(last.correspondences, all.correspondences);
  EXPECT_EQ(first.num_distances + last.num_distances, all.num_distances);
  EXPECT_EQ(last.num_matched_keypoints, all.num_matched_keypoints);

  const MatchingOptions limited = {.max_keypoints_of_landmark = 2};
  FeatureMatcher limited_matcher(query, tiles, limited);
  limited_matcher.MatchUpTo(kFirst, nullptr, {});
  expect_same(limited_matcher.MatchUpTo(kNumKeypoints, nullptr, {}).correspondences,
              MatchFeatures(query, tiles, limited).correspondences);
}

TEST(MatchFeatures, GoesOnWithWhatItHasWhenToldToStop) {
  const std::vector<TileView> tiles = {SimpleView(SimpleTile({{1, {{0.1f}}}})),
                                       SimpleView(SimpleTile({{2, {{0.2f}}}}))};
  const QueryContext query = SimpleQuery({{0.0f}});
  // The landmarks found, stopping at the n-th question.
  const auto match = [&](int n) {
    int num_questions = 0;
    return MatchFeatures(query, tiles, {}, nullptr, [&] { return ++num_questions >= n; });
  };
  EXPECT_EQ(match(1).correspondences.size(), 0u);
  EXPECT_EQ(match(1).num_distances, 0);
  EXPECT_TRUE(match(1).was_stopped);
  EXPECT_EQ(match(3).correspondences.size(), 1u);  // Asked before each tile and in it.
  EXPECT_TRUE(match(3).was_stopped);
  EXPECT_EQ(match(1'000).correspondences.size(), 2u);
  EXPECT_FALSE(match(1'000).was_stopped);
}

TEST(MatchFeatures, RefuseTilesOfDifferentCodebooks) {
  Tile other = SimpleTile({{1, {{0.1f}}}});
  other.codebook_id = CodebookId{2};
  EXPECT_THROW(
      Match(SimpleQuery({{0.0f}}), {SimpleView(SimpleTile({})), SimpleView(std::move(other))}),
      Error);
}

}  // namespace
}  // namespace cairn
