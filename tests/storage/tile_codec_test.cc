#include "storage/tile/tile_codec.h"

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

// Every third descriptor in one of three lists; a fourth is empty.
TileLists ThreeLists(const Tile& tile) {
  TileLists lists;
  for (uint32_t list = 0; list < 3; ++list) {
    lists.begin.push_back(static_cast<uint32_t>(lists.members.size()));
    for (uint32_t i = list; i < tile.num_descriptors(); i += 3) {
      lists.members.push_back(i);
    }
  }
  lists.begin.insert(lists.begin.end(), 2, static_cast<uint32_t>(lists.members.size()));
  return lists;
}

Tile EmptyTile() {
  Tile tile;
  tile.id = TileId::Containing(Geodetic::FromDegrees(10.0, 20.0, 0.0));
  tile.code_size = 8;
  tile.descriptor_begin = {0};
  tile.history_begin = {0};
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
  tile.history[2] = {SessionId(INT64_MAX), 255, 255};
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

TEST(TileCodec, RoundTripOfListsIsExact) {
  for (const int num_landmarks : {10, 100, 5000}) {
    testing::RandomTileOptions options;
    options.num_landmarks = num_landmarks;
    const Tile tile = RandomTile(options);
    const std::vector<uint8_t> blob = EncodeTile(tile, ThreeLists(tile));
    TileLists lists;
    EXPECT_TRUE(SameTile(DecodeTile(blob, {}, &lists), tile)) << num_landmarks;
    EXPECT_EQ(lists, ThreeLists(tile)) << num_landmarks;
  }
}

TEST(TileCodec, ATileWithoutListsHasNone) {
  TileLists lists = ThreeLists(SmallTile());
  DecodeTile(EncodeTile(SmallTile()), {}, &lists);
  EXPECT_TRUE(lists.empty());
}

// Gaps of more than 16 bits, and rows of codes of another size than the usual.
TEST(TileCodec, RoundTripOfListsOfManyDescriptors) {
  testing::RandomTileOptions options;
  options.num_landmarks = 60'000;
  options.code_size = 3;
  const Tile tile = RandomTile(options);
  const auto size = static_cast<uint32_t>(tile.num_descriptors());
  ASSERT_GT(size, 70'000u);
  TileLists lists;
  lists.begin = {0, 2, size};
  lists.members = {0, size - 1};
  for (uint32_t i = 1; i + 1 < size; ++i) {
    lists.members.push_back(i);
  }
  TileLists decoded;
  EXPECT_TRUE(SameTile(DecodeTile(EncodeTile(tile, lists), {}, &decoded), tile));
  EXPECT_EQ(decoded, lists);
}

TEST(TileCodec, RefusesToEncodeListsOfOtherDescriptors) {
  const Tile tile = SmallTile();
  const auto expect_internal = [&](const TileLists& lists) {
    try {
      EncodeTile(tile, lists);
      ADD_FAILURE() << "accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInternal) << error.what();
    }
  };
  TileLists lists = ThreeLists(tile);
  lists.members.pop_back();
  expect_internal(lists);
  lists = ThreeLists(tile);
  std::swap(lists.members[0], lists.members[1]);
  expect_internal(lists);
  lists = ThreeLists(tile);
  std::swap(lists.begin[1], lists.begin[2]);
  expect_internal(lists);
}

// Payloads without lists and with them.
class TileCodecDamage : public ::testing::TestWithParam<std::string> {
 protected:
  static std::vector<uint8_t> Blob() {
    return EncodeTile(SmallTile(), GetParam() == "lists" ? ThreeLists(SmallTile()) : TileLists());
  }
};

TEST_P(TileCodecDamage, None) { EXPECT_TRUE(DecodesOrIsDamaged(Blob())); }

TEST_P(TileCodecDamage, EveryTruncation) {
  const std::vector<uint8_t> blob = Blob();
  for (size_t size = 0; size < blob.size(); ++size) {
    EXPECT_FALSE(DecodesOrIsDamaged({blob.begin(), blob.begin() + size})) << size;
  }
}

TEST_P(TileCodecDamage, EveryFlippedBit) {
  std::vector<uint8_t> blob = Blob();
  for (size_t bit = 0; bit < 8 * blob.size(); ++bit) {
    blob[bit / 8] ^= 1 << bit % 8;
    EXPECT_FALSE(DecodesOrIsDamaged(blob)) << "bit " << bit;
    blob[bit / 8] ^= 1 << bit % 8;
  }
}

TEST_P(TileCodecDamage, AnAppendedByte) {
  std::vector<uint8_t> blob = Blob();
  blob.push_back(0);
  EXPECT_FALSE(DecodesOrIsDamaged(blob));
}

INSTANTIATE_TEST_SUITE_P(Payloads, TileCodecDamage, ::testing::Values("no_lists", "lists"));

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

TEST(SessionsInPayload, AreThoseOfKeyframesAndHistories) {
  Tile tile = SmallTile();
  tile.keyframes[0].session_id = SessionId(7);
  tile.history[1].session_id = SessionId(9);
  EXPECT_EQ(SessionsInPayload(EncodeTile(tile)),
            (std::set<SessionId>{SessionId(1), SessionId(7), SessionId(9)}));
  EXPECT_TRUE(SessionsInPayload(std::vector<uint8_t>(100, 7)).empty());
}

}  // namespace
}  // namespace cairn
