#include "ingest/tiles/tile_edit.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "core/angles.h"
#include "storage/map/describe_tile.h"

namespace cairn {
namespace {

const TileId kTileId = TileId::Containing(Geodetic::FromDegrees(47.0, 8.0, 400.0));

// Landmark i stands at x = i m, has i % 3 + 1 descriptors with codes 10 i + d, and is seen by
// keyframes 0 (all) and 1 (the odd ones).
Tile MakeTile(SessionId session_id, int num_landmarks) {
  Tile tile = EmptyTile(kTileId, CodebookId(1), 2);
  for (int i = 0; i < num_landmarks; ++i) {
    tile.landmark_ids.push_back(LandmarkId(1000 * Value(session_id) + i));
    tile.history.push_back({session_id, 2, 3});
    tile.history_begin.push_back(static_cast<uint32_t>(tile.history.size()));
    tile.x_in_tile.push_back(Eigen::Vector3f(static_cast<float>(i), 0.0f, 401.0f));
    tile.sigma_codes.push_back(static_cast<uint8_t>(i));
    for (int d = 0; d <= i % 3; ++d) {
      tile.codes.push_back(static_cast<uint8_t>(10 * i + d));
      tile.codes.push_back(7);
      tile.orientation_codes.push_back(static_cast<uint8_t>(i));
      tile.size_codes.push_back(static_cast<uint8_t>(d));
      tile.azimuth_codes.push_back(static_cast<uint8_t>(i + d));
      tile.weight_codes.push_back(static_cast<uint8_t>(4 + d));
    }
    tile.descriptor_begin.push_back(static_cast<uint32_t>(tile.num_descriptors()));
  }
  for (int k = 0; k < 2; ++k) {
    tile.keyframes.push_back(
        {KeyframeId(10 * Value(session_id) + k), session_id,
         Rigid3d(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.0, 0.0, -400.0 - k))});
    for (int i = 0; i < num_landmarks; ++i) {
      if (k == 0 || i % 2 == 1) {
        tile.keyframe_landmarks.push_back(i);
      }
    }
    tile.keyframe_begin.push_back(static_cast<uint32_t>(tile.keyframe_landmarks.size()));
  }
  return tile;
}

void ExpectEqual(const Tile& a, const Tile& b) {
  EXPECT_EQ(a.landmark_ids, b.landmark_ids);
  EXPECT_EQ(a.history_begin, b.history_begin);
  EXPECT_EQ(a.history, b.history);
  EXPECT_EQ(a.weight_codes, b.weight_codes);
  EXPECT_EQ(a.x_in_tile, b.x_in_tile);
  EXPECT_EQ(a.sigma_codes, b.sigma_codes);
  EXPECT_EQ(a.descriptor_begin, b.descriptor_begin);
  EXPECT_EQ(a.codes, b.codes);
  EXPECT_EQ(a.orientation_codes, b.orientation_codes);
  EXPECT_EQ(a.size_codes, b.size_codes);
  EXPECT_EQ(a.azimuth_codes, b.azimuth_codes);
  EXPECT_EQ(a.keyframe_begin, b.keyframe_begin);
  EXPECT_EQ(a.keyframe_landmarks, b.keyframe_landmarks);
  ASSERT_EQ(a.num_keyframes(), b.num_keyframes());
  for (size_t k = 0; k < a.num_keyframes(); ++k) {
    EXPECT_EQ(a.keyframes[k].id, b.keyframes[k].id);
  }
}

TEST(PickLandmarks, TakesThemInTheOrderGiven) {
  const std::vector<uint32_t> chosen = {3, 0, 5};
  const Tile picked = PickLandmarks(MakeTile(SessionId(1), 6), chosen);
  EXPECT_NO_THROW(picked.Validate());
  ASSERT_EQ(picked.num_landmarks(), 3u);
  EXPECT_EQ(picked.x_in_tile[0].x(), 3.0f);
  EXPECT_EQ(picked.x_in_tile[2].x(), 5.0f);
  EXPECT_EQ(picked.descriptor_begin, (std::vector<uint32_t>{0, 1, 2, 5}));
  EXPECT_EQ(picked.codes, (std::vector<uint8_t>{30, 7, 0, 7, 50, 7, 51, 7, 52, 7}));
  EXPECT_EQ(picked.keyframe_landmarks, (std::vector<uint32_t>{0, 1, 2, 0, 2}));
}

TEST(PickLandmarks, OfAllInOrderChangesNothing) {
  const Tile tile = MakeTile(SessionId(1), 4);
  ExpectEqual(PickLandmarks(tile, std::vector<uint32_t>{0, 1, 2, 3}), tile);
}

TEST(AppendTile, JoinsAndWithoutSessionTakesApart) {
  const Tile a = MakeTile(SessionId(1), 5), b = MakeTile(SessionId(2), 4);
  Tile joined = a;
  AppendTile(b, &joined);
  EXPECT_NO_THROW(joined.Validate());
  EXPECT_EQ(joined.num_landmarks(), 9u);
  EXPECT_EQ(joined.num_keyframes(), 4u);
  ExpectEqual(WithoutSession(joined, SessionId(2)), a);
  ExpectEqual(WithoutSession(joined, SessionId(1)), b);
  ExpectEqual(WithoutSession(joined, SessionId(3)), joined);
}

TEST(CutKeyframes, TakesWhatTheySee) {
  const Tile tile = MakeTile(SessionId(1), 5);
  const auto is_second = [](const TileKeyframe& keyframe) { return keyframe.id == KeyframeId(11); };
  ExpectEqual(CutKeyframes(
                  tile, [](const TileKeyframe&) { return true; }, false),
              tile);
  const Tile cut = CutKeyframes(tile, is_second, true);  // Every landmark is seen by the other.
  EXPECT_EQ(cut.landmark_ids, (std::vector<LandmarkId>{LandmarkId(1001), LandmarkId(1003)}));
  EXPECT_EQ(cut.num_keyframes(), 1u);
  const Tile odd = PickKeyframes(tile, is_second);  // Landmarks 0, 2 and 4 have no keyframe.
  EXPECT_EQ(CutKeyframes(odd, is_second, false).num_landmarks(), 2u);
  ExpectEqual(CutKeyframes(odd, is_second, true), odd);
  EXPECT_EQ(CutKeyframes(odd, std::not_fn(is_second), true).num_landmarks(), 3u);
}

TEST(AppendMissing, KeepsLandmarksThatAreThereAndAddsKeyframes) {
  const Tile tile = MakeTile(SessionId(1), 5);
  const auto is_second = [](const TileKeyframe& keyframe) { return keyframe.id == KeyframeId(11); };
  Tile joined = CutKeyframes(tile, is_second, false);
  Tile rest = CutKeyframes(tile, std::not_fn(is_second), false);
  rest.sigma_codes.assign(rest.num_landmarks(), 99);
  AppendMissing(rest, &joined);
  EXPECT_NO_THROW(joined.Validate());
  ASSERT_EQ(joined.num_landmarks(), 5u);
  EXPECT_EQ(joined.sigma_codes, (std::vector<uint8_t>{1, 3, 99, 99, 99}));
  ASSERT_EQ(joined.num_keyframes(), 2u);
  EXPECT_EQ(joined.LandmarksOfKeyframe(0).size(), 2u);
  EXPECT_EQ(joined.LandmarksOfKeyframe(1).size(), 5u);
}

TEST(WithoutSession, LeavesLandmarksThatOthersSawWithoutItsHistory) {
  Tile tile = MakeTile(SessionId(1), 3);
  ReplaceHistories({{{SessionId(1), 2, 2}, {SessionId(2), 4, 5}},
                    {{SessionId(1), 2, 2}, {SessionId(2), 0, 3}},
                    {{SessionId(), 9, 9}, {SessionId(1), 1, 1}}},
                   &tile);
  EXPECT_NO_THROW(tile.Validate());
  const Tile without = WithoutSession(tile, SessionId(1));
  ASSERT_EQ(without.num_landmarks(), 2u);
  EXPECT_EQ(without.landmark_ids[0], tile.landmark_ids[0]);
  EXPECT_EQ(without.HistoryOf(0)[0], (HistoryEntry{SessionId(2), 4, 5}));
  EXPECT_EQ(without.landmark_ids[1], tile.landmark_ids[2]);
  EXPECT_EQ(without.HistoryOf(1)[0], (HistoryEntry{SessionId(), 9, 9}));
  EXPECT_EQ(without.num_keyframes(), 0u);
}

TEST(AppendTile, ToAnEmptyTileIsACopy) {
  Tile tile = EmptyTile(kTileId, CodebookId(1), 2);
  AppendTile(MakeTile(SessionId(1), 5), &tile);
  ExpectEqual(tile, MakeTile(SessionId(1), 5));
}

TEST(DescribeTile, FindsHeightsAndBounds) {
  const TileRecord record = DescribeTile(MakeTile(SessionId(1), 5));
  EXPECT_EQ(record.num_landmarks, 5);
  EXPECT_EQ(record.num_descriptors, 9);
  EXPECT_EQ(record.num_keyframes, 2);
  EXPECT_NEAR(record.min_h_m, 400.0, 1e-6);
  EXPECT_NEAR(record.max_h_m, 401.0, 1e-6);
  EXPECT_NEAR(record.landmark_bounds.west_rad, kTileId.Anchor().lon_rad, 1e-12);
  // Four meters east.
  const double radius_m = 6'378'137.0 * std::cos(kTileId.Anchor().lat_rad);
  EXPECT_NEAR((record.landmark_bounds.east_rad - record.landmark_bounds.west_rad) * radius_m, 4.0,
              0.02);
}

TEST(DescribeTile, BoundsAtTheAntimeridianAreNarrow) {
  Tile tile = MakeTile(SessionId(1), 5);
  tile.id = TileId::Containing(Geodetic::FromDegrees(-17.0, 179.9999, 400.0));
  for (int i = 0; i < 5; ++i) {
    tile.x_in_tile[i].x() = 60.0f * (i - 2);
  }
  const GeoBox bounds = DescribeTile(tile).landmark_bounds;
  EXPECT_TRUE(bounds.CrossesAntimeridian());
  EXPECT_LT(bounds.east_rad + 2.0 * kPi - bounds.west_rad, 1e-4);
}

}  // namespace
}  // namespace cairn
