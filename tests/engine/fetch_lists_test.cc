#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <latch>
#include <memory>
#include <numeric>
#include <optional>
#include <thread>
#include <vector>

#include "core/error.h"
#include "core/large_vector.h"
#include "engine/index/inverted_lists.h"
#include "engine/index_under_test.h"
#include "engine/tiles/fetch_tiles.h"
#include "engine/tiles/searchable_tile.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/tile/checksum.h"
#include "storage/tile/tile_codec.h"
#include "storage/tile/tile_payload.h"
#include "support/map_builder.h"
#include "support/temp_dir.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using testing::ErrorCodeOf;
using testing::RandomTile;

// Lists need not decode a tile to search it.
class FetchListsTest : public ::testing::Test {
 protected:
  FetchListsTest() : tile_(RandomTile({.num_landmarks = 500})) {
    options_.kind = IndexKind::kInvertedLists;
    options_.lists.num_lists = 20;
    options_.grids.num_probes = 28;  // Some queries find more than their own descriptor.
    lists_ = MakeTileLists(*codebook_, tile_.codes, options_.lists);
  }

  std::unique_ptr<const SearchableTile> FromPayload(const std::vector<uint8_t>& bytes) const {
    return std::make_unique<const SearchableTile>(
        TilePayload(LargeVector<uint8_t>(bytes.begin(), bytes.end())), codebook_, options_);
  }

  // That all that the searchable tile tells of the tile is right.
  void ExpectContent(const SearchableTile& searchable) const {
    const auto expect_same = [](const auto& told, const auto& expected) {
      EXPECT_TRUE(std::equal(told.begin(), told.end(), expected.begin(), expected.end()));
    };
    const TileLandmarks& landmarks = searchable.landmarks();
    expect_same(landmarks.landmark_ids, tile_.landmark_ids);
    expect_same(landmarks.x_in_tile, tile_.x_in_tile);
    expect_same(landmarks.sigma_codes, tile_.sigma_codes);
    expect_same(landmarks.descriptor_begin, tile_.descriptor_begin);
    expect_same(landmarks.orientation_codes, tile_.orientation_codes);
    expect_same(landmarks.size_codes, tile_.size_codes);
    expect_same(landmarks.azimuth_codes, tile_.azimuth_codes);
    const TileCovisibility& covisibility = searchable.covisibility();
    expect_same(covisibility.keyframe_begin, tile_.keyframe_begin);
    expect_same(covisibility.keyframe_landmarks, tile_.keyframe_landmarks);
    Tile with_keyframes = tile_;
    with_keyframes.keyframes.assign(covisibility.keyframes.begin(), covisibility.keyframes.end());
    EXPECT_TRUE(testing::SameTile(with_keyframes, tile_));
    expect_same(searchable.codes(), tile_.codes);
    const LandmarkKeyframes expected(tile_, tile_);
    for (const LandmarkId id : tile_.landmark_ids) {
      expect_same(searchable.landmark_keyframes().KeyframesThatSaw(id),
                  expected.KeyframesThatSaw(id));
    }
  }

  // That a search finds the same hits in both, whose places and contents are the same.
  void ExpectAlike(const SearchableTile& from_payload, const SearchableTile& decoded) const {
    const DescriptorMatrix queries =
        DescriptorCodec(codebook_).Decode(tile_.codes.data(), 50) +
        DescriptorMatrix::Constant(50, codebook_->projected_dim(), 0.01f);
    std::vector<DescriptorHit> hits, expected;
    EXPECT_EQ(from_payload.index().RangeSearch(queries, 2.0, &hits),
              decoded.index().RangeSearch(queries, 2.0, &expected));
    ASSERT_GT(expected.size(), 50u);
    ASSERT_EQ(hits.size(), expected.size());
    for (size_t i = 0; i < hits.size(); ++i) {
      EXPECT_EQ(hits[i].query_idx, expected[i].query_idx);
      EXPECT_EQ(hits[i].descriptor_idx, expected[i].descriptor_idx);
      EXPECT_EQ(hits[i].sq_distance, expected[i].sq_distance);
    }
    ASSERT_EQ(from_payload.places().size(), tile_.num_descriptors());
    for (size_t place = 0; place < tile_.num_descriptors(); ++place) {
      ASSERT_EQ(from_payload.places().descriptor(place), decoded.places().descriptor(place));
      ASSERT_EQ(from_payload.places().landmark(place), decoded.places().landmark(place));
    }
    ExpectContent(from_payload);
  }

  // Where a column of a payload begins; docs/formats/tile_v1.md.
  size_t OffsetOfColumn(const std::vector<uint8_t>& payload, size_t column) const {
    constexpr size_t kDirectoryOffset = 72, kNumColumns = 66;
    std::vector<uint32_t> stored_sizes(kNumColumns);
    std::memcpy(stored_sizes.data(), payload.data() + kDirectoryOffset,
                kNumColumns * sizeof(uint32_t));
    return kDirectoryOffset + kNumColumns * sizeof(uint32_t) + tile_.codes.size() +
           std::accumulate(stored_sizes.begin(),
                           stored_sizes.begin() + static_cast<ptrdiff_t>(column), size_t{0});
  }

  // Sets a few bytes to what is too much of anything, and the checksum to what it then is.
  static std::vector<uint8_t> WithDamage(std::vector<uint8_t> payload, size_t offset) {
    constexpr size_t kNumBytes = 4, kChecksumOffset = 64;
    std::fill_n(payload.begin() + static_cast<ptrdiff_t>(offset), kNumBytes, 0xff);
    const uint64_t checksum = ChecksumOf(payload, kChecksumOffset);
    std::memcpy(payload.data() + kChecksumOffset, &checksum, sizeof(checksum));
    return payload;
  }

  std::shared_ptr<const Codebook> codebook_ =
      std::make_shared<const Codebook>(testing::RandomCodebook());
  Tile tile_;
  IndexOptions options_;
  TileLists lists_;
};

TEST_F(FetchListsTest, APayloadIsSearchedAsItsTileIs) {
  const auto from_payload = FromPayload(EncodeTile(tile_, lists_));
  ExpectAlike(*from_payload, SearchableTile(tile_, codebook_, options_, lists_));
  EXPECT_EQ(from_payload->id(), tile_.id);
  EXPECT_EQ(from_payload->num_descriptors(), tile_.num_descriptors());
}

TEST_F(FetchListsTest, APayloadWithAnotherIndexIsSearchedAsItsTileIs) {
  const std::vector<uint8_t> bytes = EncodeTile(tile_, lists_);
  IndexOptions two_grids;
  two_grids.grids.num_grids = 2;
  for (const IndexOptions& other : {IndexOptions(), two_grids, testing::OtherIndex()}) {
    options_.kind = other.kind;
    options_.other = other.other;
    options_.grids.num_grids = other.grids.num_grids;
    const auto from_payload =
        MakeSearchableTile(LargeVector<uint8_t>(bytes.begin(), bytes.end()), codebook_, options_);
    from_payload->Prepare();
    while (!from_payload->index().is_complete()) {
      from_payload->index().BuildPart();
    }
    ExpectAlike(*from_payload, SearchableTile(tile_, codebook_, options_, lists_));
  }
}

// The copy of the codes in tile order is made when a query needs it.
TEST_F(FetchListsTest, OneGridIsBuiltFromTheCodesAsTheyAreStored) {
  const std::vector<uint8_t> bytes = EncodeTile(tile_, lists_);
  const auto num_bytes = [&](int num_grids) {
    options_.kind = IndexKind::kRandomGrids;
    options_.grids.num_grids = num_grids;
    const auto searchable =
        MakeSearchableTile(LargeVector<uint8_t>(bytes.begin(), bytes.end()), codebook_, options_);
    const size_t all = searchable->MemoryBytes();
    ExpectContent(*searchable);
    EXPECT_EQ(searchable->MemoryBytes(), all);
    return all - searchable->index().MemoryBytes();
  };
  EXPECT_TRUE(SearchableTile::NeedsCodesAsStored(IndexOptions()));
  EXPECT_LT(num_bytes(1), num_bytes(2));
}

TEST_F(FetchListsTest, ThreadsThatAskTogetherGetOneOfEachPart) {
  const std::vector<uint8_t> payload = EncodeTile(tile_, lists_);
  const auto searchable = FromPayload(payload);
  const size_t num_bytes = searchable->MemoryBytes();
  std::vector<const TileLandmarks*> landmarks(8, nullptr);
  std::vector<const TileCovisibility*> covisibilities(8, nullptr);
  std::vector<const LandmarkKeyframes*> found(8, nullptr);
  {
    std::vector<std::jthread> threads;
    for (size_t i = 0; i < landmarks.size(); ++i) {
      threads.emplace_back([&, i] {
        if (i % 4 == 1) {  // Any part may come first.
          found[i] = &searchable->landmark_keyframes();
        } else if (i % 2 == 0) {
          landmarks[i] = &searchable->landmarks();
        }
        covisibilities[i] = &searchable->covisibility();
        landmarks[i] = &searchable->landmarks();
        found[i] = &searchable->landmark_keyframes();
      });
    }
  }
  EXPECT_THAT(landmarks, ::testing::Each(landmarks.front()));
  EXPECT_THAT(covisibilities, ::testing::Each(covisibilities.front()));
  EXPECT_THAT(found, ::testing::Each(found.front()));
  ExpectContent(*searchable);
  EXPECT_EQ(searchable->MemoryBytes(), num_bytes);
  const size_t session_bytes = tile_.num_landmarks() * sizeof(SessionId);  // Are not kept.
  const size_t tile_bytes = DecodeTile(payload).MemoryBytes();
  EXPECT_GE(num_bytes + session_bytes, tile_bytes + searchable->index().MemoryBytes());
}

// Damage that the checksum does not show: whoever makes it can compute that too.
TEST_F(FetchListsTest, AHalfOfATileThatDoesNotDecodeIsDamagedEveryTime) {
  const std::vector<uint8_t> sound = EncodeTile(tile_, lists_);
  constexpr size_t kDescriptorCounts = 24, kObservations = 65;
  const auto bad_landmarks =
      FromPayload(WithDamage(sound, OffsetOfColumn(sound, kDescriptorCounts)));
  const auto bad_rest = FromPayload(WithDamage(sound, OffsetOfColumn(sound, kObservations)));
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(ErrorCodeOf([&] { bad_landmarks->landmarks(); }), ErrorCode::kMapDamaged);
    EXPECT_EQ(ErrorCodeOf([&] { bad_landmarks->places(); }), ErrorCode::kMapDamaged);
    EXPECT_EQ(ErrorCodeOf([&] { bad_rest->covisibility(); }), ErrorCode::kMapDamaged);
    EXPECT_EQ(ErrorCodeOf([&] { bad_rest->codes(); }), ErrorCode::kMapDamaged);
    EXPECT_EQ(ErrorCodeOf([&] { bad_landmarks->landmark_keyframes(); }), ErrorCode::kMapDamaged);
    EXPECT_EQ(ErrorCodeOf([&] { bad_rest->landmark_keyframes(); }), ErrorCode::kMapDamaged);
  }
  EXPECT_EQ(bad_landmarks->covisibility().keyframe_landmarks.size(),
            tile_.keyframe_landmarks.size());
  EXPECT_EQ(bad_rest->landmarks().num_landmarks(), tile_.num_landmarks());
  std::vector<DescriptorHit> hits;
  bad_landmarks->index().RangeSearch(DescriptorMatrix::Zero(1, codebook_->projected_dim()), 10.0,
                                     &hits);
  EXPECT_FALSE(hits.empty());
  try {
    bad_rest->covisibility();
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr(tile_.id.ToString()));
  }
}

TEST_F(FetchListsTest, WhatMatchingNeedsIsDecodedIfThereIsTime) {
  constexpr size_t kDescriptorCounts = 24;
  const testing::TempDir dir;
  MapStore store = MapStore::Create(dir.File("map.gpkg"));
  MapUpdate update = store.BeginUpdate();
  ASSERT_EQ(update.AddCodebook(testing::RandomCodebook()), tile_.codebook_id);
  testing::AddTile(tile_, &update);
  const std::vector<uint8_t> sound = EncodeTile(tile_, lists_);
  update.PutTile(testing::RecordOf(tile_),
                 WithDamage(sound, OffsetOfColumn(sound, kDescriptorCounts)));
  update.Publish();
  const auto fetch = [&](const StopFunction& should_stop) {
    TileCache cache(1 << 26, options_);
    SearchRegion region;
    region.ecef_from_anchor = EcefFromEnu(tile_.id.Anchor());
    return FetchTiles(SnapshotTiles(store.Snapshot()), region, {}, &cache, should_stop).views;
  };
  EXPECT_EQ(ErrorCodeOf([&] { fetch({}); }), ErrorCode::kMapDamaged);
  const std::vector<TileView> hasty = fetch([] { return true; });
  ASSERT_EQ(hasty.size(), 1u);
  EXPECT_EQ(ErrorCodeOf([&] { hasty[0].tile->Prepare(); }), ErrorCode::kMapDamaged);
}

TEST_F(FetchListsTest, RefusesThePayloadOfAnotherCodebook) {
  Codebook other = testing::RandomCodebook();
  other.id = CodebookId(2);
  codebook_ = std::make_shared<const Codebook>(other);
  const std::vector<uint8_t> bytes = EncodeTile(tile_, lists_);
  EXPECT_EQ(ErrorCodeOf([&] { FromPayload(bytes); }), ErrorCode::kMapDamaged);
}

TEST_F(FetchListsTest, APayloadWithoutListsIsNotSearchReady) {
  EXPECT_FALSE(TilePayload::IsSearchReady(EncodeTile(tile_)));
  EXPECT_TRUE(TilePayload::IsSearchReady(EncodeTile(tile_, lists_)));
  EXPECT_EQ(ErrorCodeOf([&] { FromPayload(EncodeTile(tile_)); }), ErrorCode::kMapDamaged);
}

}  // namespace
}  // namespace cairn
