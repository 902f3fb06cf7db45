#include "storage/tile_codec.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "core/error.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using testing::RandomTile;
using testing::SameTile;

// What decoding untrusted bytes may do: give a tile, or an Error(kMapDamaged). Returns true for a
// tile.
bool DecodesOrIsDamaged(const std::vector<uint8_t>& blob) {
  try {
    DecodeTile(blob).Validate();
    return true;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kMapDamaged) << error.what();
    return false;
  }
}

Tile SmallTile() {
  testing::RandomTileOptions options;
  options.num_landmarks = 6;
  options.num_keyframes = 2;
  options.num_landmarks_per_keyframe = 4;
  return RandomTile(options);
}

Tile EmptyTile() {
  Tile tile;
  tile.id = TileId::Containing(Geodetic::FromDegrees(10.0, 20.0, 0.0));
  tile.code_size = 8;
  tile.descriptor_begin = {0};
  tile.keyframe_begin = {0};
  return tile;
}

TEST(TileCodec, RoundTripIsExact) {
  for (const int num_landmarks : {1, 2, 100, 5000}) {
    testing::RandomTileOptions options;
    options.num_landmarks = num_landmarks;
    options.num_keyframes = 1 + num_landmarks / 50;
    const Tile tile = RandomTile(options);
    EXPECT_TRUE(SameTile(DecodeTile(EncodeTile(tile)), tile)) << num_landmarks;
  }
}

TEST(TileCodec, RoundTripOfATileWithoutLandmarks) {
  EXPECT_TRUE(SameTile(DecodeTile(EncodeTile(EmptyTile())), EmptyTile()));
}

TEST(TileCodec, RoundTripKeepsAnyOrderAndExtremeValues) {
  Tile tile = SmallTile();
  tile.landmark_ids[0] = LandmarkId(UINT64_MAX);
  tile.landmark_ids[1] = LandmarkId(0);
  tile.landmark_sessions[2] = SessionId(INT64_MAX);
  tile.keyframes[0].id = KeyframeId(INT64_MIN);
  tile.x_in_tile[0] = QuantizePosition({1e9, -1e9, 0.0});
  tile.x_in_tile[5] = QuantizePosition({-1e9, 1e9, -1e9});
  EXPECT_TRUE(SameTile(DecodeTile(EncodeTile(tile)), tile));
}

TEST(TileCodec, RefusesToEncodeAnInconsistentTile) {
  const auto expect_internal = [](const Tile& tile) {
    try {
      EncodeTile(tile);
      ADD_FAILURE() << "accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInternal) << error.what();
    }
  };
  Tile tile = SmallTile();
  tile.sigma_codes.pop_back();
  expect_internal(tile);
  tile = SmallTile();
  tile.x_in_tile[3].x() += 1e-3f;
  expect_internal(tile);
  tile = SmallTile();
  tile.keyframe_landmarks.back() = 6;
  expect_internal(tile);
  tile = SmallTile();
  std::swap(tile.keyframe_landmarks[0], tile.keyframe_landmarks[1]);
  expect_internal(tile);
  tile = SmallTile();
  tile.keyframes[0].cam_from_tile.translation.x() = NAN;
  expect_internal(tile);
}

TEST(TileCodec, EveryTruncationIsDamage) {
  const std::vector<uint8_t> blob = EncodeTile(SmallTile());
  for (size_t size = 0; size < blob.size(); ++size) {
    EXPECT_FALSE(DecodesOrIsDamaged({blob.begin(), blob.begin() + size})) << size;
  }
}

TEST(TileCodec, EveryFlippedBitIsDamage) {
  std::vector<uint8_t> blob = EncodeTile(SmallTile());
  for (size_t bit = 0; bit < 8 * blob.size(); ++bit) {
    blob[bit / 8] ^= 1 << bit % 8;
    EXPECT_FALSE(DecodesOrIsDamaged(blob)) << "bit " << bit;
    blob[bit / 8] ^= 1 << bit % 8;
  }
}

TEST(TileCodec, AppendedByteIsDamage) {
  std::vector<uint8_t> blob = EncodeTile(SmallTile());
  blob.push_back(0);
  EXPECT_FALSE(DecodesOrIsDamaged(blob));
}

TEST(TileCodec, LimitsHold) {
  const Tile tile = SmallTile();
  const std::vector<uint8_t> blob = EncodeTile(tile);
  const auto expect_refused = [&blob](const TileDecodeLimits& limits) {
    EXPECT_THROW(DecodeTile(blob, limits), Error);
  };
  expect_refused({.max_landmarks = 5});
  expect_refused({.max_descriptors = static_cast<uint32_t>(tile.num_descriptors() - 1)});
  expect_refused({.max_keyframes = 1});
  expect_refused({.max_decoded_bytes = 100});
}

}  // namespace
}  // namespace cairn
