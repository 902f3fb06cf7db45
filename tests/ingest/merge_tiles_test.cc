#include "ingest/tiles/merge_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <vector>

#include "ingest/tiles/admit_landmarks.h"
#include "ingest/tiles/appearance.h"
#include "ingest/tiles/tile_edit.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

std::shared_ptr<const Codebook> TestCodebook() {
  return std::make_shared<const Codebook>(testing::RandomCodebook());
}

// Two sessions' content of one tile; landmarks 20 to 49 of `fresh` are 0 to 29 of `known`.
struct TwoTiles {
  Tile known, fresh;

  TwoTiles() {
    testing::RandomTileOptions options;
    options.num_landmarks = 50;
    known = testing::RandomTile(options);
    options.seed = 2;
    options.session_id = 2;
    options.first_keyframe_id = 100;
    options.first_landmark_id = 1000;
    fresh = testing::RandomTile(options);
    for (size_t i = 0; i < 30; ++i) {
      fresh.landmark_ids[20 + i] = known.landmark_ids[i];
      fresh.x_in_tile[20 + i] = known.x_in_tile[i];
    }
  }
};

TEST(MergeTiles, JoinsEqualIdsAndAppendsTheOthers) {
  const TwoTiles tiles;
  const Tile merged = MergeTiles(tiles.known, tiles.fresh, DescriptorCodec(TestCodebook()),
                                 *MakeKMeansSummarizer({}), {});
  EXPECT_NO_THROW(merged.Validate());
  ASSERT_EQ(merged.num_landmarks(), 70u);
  ASSERT_EQ(merged.num_keyframes(), 10u);
  for (size_t i = 0; i < 50; ++i) {
    EXPECT_EQ(merged.landmark_ids[i], tiles.known.landmark_ids[i]);
    EXPECT_EQ(merged.HistoryOf(i).size(), i < 30 ? 2u : 1u);
  }
  EXPECT_EQ(merged.keyframe_landmarks.size(),
            tiles.known.keyframe_landmarks.size() + tiles.fresh.keyframe_landmarks.size());
}

TEST(MergeTiles, APositionIsTheMeanByInverseVariances) {
  TwoTiles tiles;
  tiles.known.sigma_codes[0] = SigmaCode(0.3);
  tiles.fresh.sigma_codes[20] = SigmaCode(0.1);
  tiles.known.x_in_tile[0] = {1.0f, 0.0f, 0.0f};
  tiles.fresh.x_in_tile[20] = {2.0f, 0.0f, 0.0f};
  const Tile merged = MergeTiles(tiles.known, tiles.fresh, DescriptorCodec(TestCodebook()),
                                 *MakeKMeansSummarizer({}), {});
  EXPECT_NEAR(merged.x_in_tile[0].x(), 1.9, 0.02);
  EXPECT_NEAR(SigmaFromCode(merged.sigma_codes[0]), 0.3 * 0.1 / std::hypot(0.3, 0.1), 0.01);
}

TEST(MergeTiles, AnEqualLookIsKeptOnceWithTheSumOfTheWeights) {
  TwoTiles tiles;
  const Tile one = PickLandmarks(tiles.known, std::vector<uint32_t>{0});
  Tile same = one;
  same.landmark_ids = {tiles.known.landmark_ids[0]};
  for (HistoryEntry& entry : same.history) {
    entry.session_id = SessionId(2);
  }
  same.keyframes.clear();
  same.keyframe_begin = {0};
  same.keyframe_landmarks.clear();
  const Tile merged =
      MergeTiles(one, same, DescriptorCodec(TestCodebook()), *MakeKMeansSummarizer({}), {});
  EXPECT_LE(merged.num_descriptors(), one.num_descriptors());
  EXPECT_GT(WeightFromCode(merged.weight_codes[0]), WeightFromCode(tiles.known.weight_codes[0]));
}

TEST(MergeTiles, NeverKeepsMoreDescriptorsThanAllowed) {
  TwoTiles tiles;
  AppearanceOptions options;
  options.count = 2;
  const Tile merged = MergeTiles(tiles.known, tiles.fresh, DescriptorCodec(TestCodebook()),
                                 *MakeKMeansSummarizer(options), {});
  for (size_t i = 0; i < 30; ++i) {
    EXPECT_LE(merged.descriptor_begin[i + 1] - merged.descriptor_begin[i], 2u);
  }
}

// Tiles of one landmark, which has one descriptor in `known` and the others in `fresh`. Each byte
// of a code is one of `num_words`.
struct OneLandmark {
  Tile known, fresh;

  OneLandmark(int num_descriptors, int num_words) {
    const TwoTiles tiles;
    std::mt19937_64 random(3);
    known = PickLandmarks(tiles.known, std::vector<uint32_t>{0});
    fresh = PickLandmarks(tiles.fresh, std::vector<uint32_t>{20});
    const auto fill = [&](int count, Tile* tile) {
      tile->descriptor_begin = {0, static_cast<uint32_t>(count)};
      tile->codes.clear();
      for (int i = 0; i < count * tile->code_size; ++i) {
        tile->codes.push_back(static_cast<uint8_t>(random() % num_words));
      }
      tile->orientation_codes.assign(count, kNoOrientation);
      tile->size_codes.assign(count, 0);
      tile->azimuth_codes.assign(count, AzimuthCode(0.0));
      tile->weight_codes.assign(count, WeightCode(2.0));
    };
    fill(1, &known);
    fill(num_descriptors - 1, &fresh);
  }
};

struct HeavyRow {
  Eigen::RowVectorXf row;
  double weight;
};

// Averages the nearest two rows again and again. Compares each pair each time.
std::vector<HeavyRow> AveragedOneByOne(std::vector<HeavyRow> rows, float max_sq_distance) {
  while (true) {
    float least = std::numeric_limits<float>::max();
    size_t a = 0, b = 0;
    for (size_t i = 0; i < rows.size(); ++i) {
      for (size_t j = i + 1; j < rows.size(); ++j) {
        const float sq_distance = (rows[i].row - rows[j].row).squaredNorm();
        if (sq_distance < least) {
          least = sq_distance;
          a = i;
          b = j;
        }
      }
    }
    if (least > max_sq_distance) {
      return rows;
    }
    const double weight = rows[a].weight + rows[b].weight;
    const Eigen::RowVectorXf mean = static_cast<float>(rows[a].weight / weight) * rows[a].row +
                                    static_cast<float>(rows[b].weight / weight) * rows[b].row;
    rows[a] = {mean, weight};
    rows.erase(rows.begin() + static_cast<std::ptrdiff_t>(b));
  }
}

TEST(MergeTiles, AveragesTheNearestTwoEachTime) {
  const DescriptorCodec codec(TestCodebook());
  AppearanceOptions all;
  all.count = 1000;
  for (const int num_words : {2, 3, 256}) {  // With few words, many pairs are equally near.
    const OneLandmark tiles(60, num_words);
    std::vector<HeavyRow> rows;
    for (const Tile* tile : {&tiles.known, &tiles.fresh}) {
      const DescriptorMatrix decoded =
          codec.Decode(tile->codes.data(), static_cast<int>(tile->num_descriptors()));
      for (int i = 0; i < decoded.rows(); ++i) {
        rows.push_back({decoded.row(i), WeightFromCode(WeightCode(2.0))});
      }
    }
    for (const double share : {2.0, 3.0, 4.0}) {  // Of the median distance, which is 1.
      MergeOptions options;
      options.old_weight_share = 1.0;
      options.same_look_share = share;
      const Tile merged =
          MergeTiles(tiles.known, tiles.fresh, codec, *MakeKMeansSummarizer(all), options);
      const std::vector<HeavyRow> expected =
          AveragedOneByOne(rows, static_cast<float>(share * share));
      ASSERT_EQ(merged.num_descriptors(), expected.size());
      for (size_t i = 0; i < expected.size(); ++i) {
        EXPECT_EQ(merged.weight_codes[i], WeightCode(expected[i].weight));
        const std::vector<uint8_t> code = codec.Encode(DescriptorMatrix(expected[i].row));
        EXPECT_TRUE(
            std::equal(code.begin(), code.end(),
                       merged.codes.begin() + static_cast<std::ptrdiff_t>(i * code.size())));
      }
    }
  }
}

// A thousand times as many descriptors as a landmark has: ten billion comparisons of two, if each
// average compared all pairs again.
TEST(MergeTiles, ALandmarkOfThousandsOfDescriptorsIsMergedAtOnce) {
  const OneLandmark tiles(4000, 256);
  MergeOptions options;
  options.same_look_share = 100.0;
  const Tile merged = MergeTiles(tiles.known, tiles.fresh, DescriptorCodec(TestCodebook()),
                                 *MakeKMeansSummarizer({}), options);
  EXPECT_EQ(merged.num_descriptors(), 1u);
}

TEST(AdmitLandmarks, TakesWhatIsKnownAndFillsUpWhatIsMissing) {
  TwoTiles tiles;
  for (size_t i = 0; i < 15; ++i) {
    tiles.fresh.landmark_ids[20 + i] = LandmarkId(5000 + i);  // Half of the common ones.
  }
  const std::vector<uint32_t> only_known = AdmitLandmarks(tiles.known, tiles.fresh, 0);
  EXPECT_EQ(only_known.size(), 15u);
  const std::vector<uint32_t> all = AdmitLandmarks(tiles.known, tiles.fresh, 1000);
  std::vector<bool> is_seen(50, false);
  for (const uint32_t i : tiles.fresh.keyframe_landmarks) {
    is_seen[i] = true;
  }
  for (const uint32_t i : all) {
    EXPECT_TRUE(is_seen[i] || i >= 35);
  }
  EXPECT_GT(all.size(), only_known.size());
  EXPECT_LT(all.size(), 50u);
}

TEST(AdmitLandmarks, APhotoThatSeesEnoughOfItsLandmarksInTheMapAddsNone) {
  TwoTiles tiles;
  tiles.fresh.keyframe_landmarks.clear();
  tiles.fresh.keyframe_begin = {0};
  for (size_t k = 0; k < tiles.fresh.num_keyframes(); ++k) {
    for (uint32_t i = 12; i < 30; ++i) {  // 10 of them are known, 55 %.
      tiles.fresh.keyframe_landmarks.push_back(i);
    }
    tiles.fresh.keyframe_begin.push_back(
        static_cast<uint32_t>(tiles.fresh.keyframe_landmarks.size()));
  }
  EXPECT_EQ(AdmitLandmarks(tiles.known, tiles.fresh, 250).size(), 30u);
}

TEST(AdmitLandmarks, ASessionThatSeesMuchMoreThanTheMapIsTakenIn) {
  testing::RandomTileOptions options;
  options.num_landmarks = 500;
  options.num_landmarks_per_keyframe = 250;
  options.first_landmark_id = 1000;
  const Tile fresh = testing::RandomTile(options);
  const Tile known = PickLandmarks(fresh, [] {
    std::vector<uint32_t> every_third;
    for (uint32_t i = 0; i < 500; i += 3) {
      every_third.push_back(i);
    }
    return every_third;
  }());
  const std::set<uint32_t> seen(fresh.keyframe_landmarks.begin(), fresh.keyframe_landmarks.end());
  const std::vector<uint32_t> admitted = AdmitLandmarks(known, fresh, 100);
  const auto num_seen =
      std::count_if(admitted.begin(), admitted.end(), [&](uint32_t i) { return seen.contains(i); });
  // A third of 250 is enough for a photo that needs 100, but not for this session.
  EXPECT_GT(num_seen, 0.55 * std::ssize(seen));
}

TEST(AdmitLandmarks, TakesAllThatAPhotoOnNewGroundSees) {
  TwoTiles tiles;
  for (size_t i = 0; i < 30; ++i) {
    tiles.fresh.landmark_ids[20 + i] = LandmarkId(5000 + i);  // Nothing is known.
  }
  std::set<uint32_t> seen(tiles.fresh.keyframe_landmarks.begin(),
                          tiles.fresh.keyframe_landmarks.end());
  EXPECT_EQ(AdmitLandmarks(tiles.known, tiles.fresh, 8).size(), seen.size());
}

}  // namespace
}  // namespace cairn
