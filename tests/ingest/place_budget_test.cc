#include "ingest/tiles/place_budget.h"

#include <gtest/gtest.h>

#include <iterator>
#include <optional>
#include <vector>

#include "ingest/tile_upkeep.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

Tile TileOfSession(int64_t session_id, uint64_t first_landmark_id, int num_landmarks = 100) {
  testing::RandomTileOptions options;
  options.num_landmarks = num_landmarks;
  options.session_id = session_id;
  options.first_landmark_id = first_landmark_id;
  options.first_keyframe_id = 100 * session_id;
  return testing::RandomTile(options);
}

// A tile with keyframes and histories of `num_sessions` sessions, twice as large as TileOfSession.
Tile TileOfSessions(int num_sessions) {
  Tile tile = TileOfSession(1, 1, /*num_landmarks=*/200);
  const Tile one = TileOfSession(1, 1);
  for (size_t k = 0; k < tile.num_keyframes(); ++k) {
    tile.keyframes[k].cam_from_tile = one.keyframes[k].cam_from_tile;
  }
  for (int i = 0; i < num_sessions; ++i) {
    tile.keyframes[static_cast<size_t>(i)].session_id = SessionId(i + 1);
  }
  return tile;
}

TEST(PlaceBudget, ATileGrowsFreelyUntilThreeSessionsHaveSeenIt) {
  const Tile fresh = TileOfSession(9, 1000);
  EXPECT_FALSE(BytesOfPlace(TileOfSessions(1), fresh, fresh).has_value());
  EXPECT_FALSE(BytesOfPlace(TileOfSessions(2), fresh, fresh).has_value());
  EXPECT_TRUE(BytesOfPlace(TileOfSessions(3), fresh, fresh).has_value());
}

TEST(PlaceBudget, HistoriesCountAsSessionsWhoseKeyframesAreGone) {
  Tile tile = TileOfSessions(1);
  tile.history[0].session_id = SessionId(7);
  tile.history[1].session_id = SessionId(8);
  const Tile fresh = TileOfSession(9, 1000);
  EXPECT_TRUE(BytesOfPlace(tile, fresh, fresh).has_value());
}

TEST(PlaceBudget, PhotosOnKnownGroundAddNothing) {
  const Tile known = TileOfSessions(3);
  const Tile fresh = TileOfSession(9, 1000);  // From the same places.
  EXPECT_EQ(BytesOfPlace(known, fresh, fresh), EstimateBytes(known));
}

TEST(PlaceBudget, NewGroundAddsWhatItsPhotosSeeAndTheTileDoesNotKnow) {
  const Tile known = TileOfSessions(3);
  const int64_t bytes = EstimateBytes(known);
  Tile fresh = TileOfSession(9, 1000);
  fresh.keyframes[0].cam_from_tile.translation.x() += 500.0;
  const std::optional<int64_t> with_one = BytesOfPlace(known, fresh, fresh);
  EXPECT_GT(with_one, bytes);
  for (size_t k = 1; k < fresh.num_keyframes(); ++k) {
    fresh.keyframes[k].cam_from_tile.translation.x() += 500.0;
  }
  const std::optional<int64_t> with_all = BytesOfPlace(known, fresh, fresh);
  EXPECT_GT(with_all, with_one);
  EXPECT_LE(with_all, bytes + EstimateBytes(fresh));
  // Landmarks that the tile knows cost nothing more.
  fresh.landmark_ids.assign(known.landmark_ids.begin(),
                            known.landmark_ids.begin() + std::ssize(fresh.landmark_ids));
  EXPECT_LT(BytesOfPlace(known, fresh, fresh), with_one);
}

TEST(PlaceBudget, ThreeSparseSessionsLeaveRoomForADenseOne) {
  const Tile known = TileOfSessions(3);
  const Tile dense = TileOfSession(9, 1000, /*num_landmarks=*/1000);
  EXPECT_NEAR(*BytesOfPlace(known, dense, dense), 1.25 * EstimateBytes(dense), 1.0);
}

TEST(PlaceBudget, KeyframesDoNotTakeAllLandmarks) {
  const Tile tile = TileOfSessions(3);
  const LandmarkSelectionOptions options;
  const std::vector<double> rates(tile.num_landmarks(), 2.0);
  const auto selector = MakeLandmarkSelector(options);
  const Tile selected = SelectLandmarks(tile, rates, /*max_bytes=*/1, options, *selector);
  EXPECT_LT(selected.num_descriptors(), tile.num_descriptors());
  EXPECT_GE(selected.num_descriptors(), tile.num_descriptors() / 2 - 4);  // Whole landmarks.
}

}  // namespace
}  // namespace cairn
