#include "ingest/place/tiles_around.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "support/tile_builder.h"

namespace cairn {
namespace {

// A row of tiles to the east of a place.
class RowOfTiles : public MapTiles {
 public:
  RowOfTiles(TileId first, int num_tiles, CodebookId codebook_id) {
    codebook_ = std::make_shared<Codebook>(testing::RandomCodebook());
    codebook_->id = CodebookId(1);
    for (int i = 0; i < num_tiles; ++i) {
      TileRecord& tile = tiles_.emplace_back();
      tile.tile_id = first.WithIndices(first.easting_idx() + i, first.northing_idx());
      tile.codebook_id = codebook_id;
    }
  }

  std::shared_ptr<const Codebook> CurrentCodebook() const override { return codebook_; }
  std::vector<TileRecord> FindTiles(const GeoBox& box) const override {
    std::vector<TileRecord> found;
    for (const TileRecord& tile : tiles_) {
      const GeoBox bounds = tile.tile_id.Bounds();
      if (bounds.west_rad <= box.east_rad && bounds.east_rad >= box.west_rad) {
        found.push_back(tile);
      }
    }
    return found;
  }
  StoredTile LoadTile(const TileRecord& /*record*/) const override { return {}; }

 private:
  std::shared_ptr<Codebook> codebook_;
  std::vector<TileRecord> tiles_;
};

const Geodetic kPlace = Geodetic::FromDegrees(49.011, 8.416, 0.0);

TEST(TilesAround, AreTheNearest) {
  const TileId first = TileId::Containing(kPlace);
  const RowOfTiles row(first, 500, CodebookId(1));
  const TilesAround around(row, {kPlace}, 1e6);
  EXPECT_FALSE(around.empty());
  const std::vector<TileRecord> found = around.FindTiles(WholeEarth());
  ASSERT_EQ(found.size(), 400u);
  for (const TileRecord& tile : found) {
    EXPECT_LT(tile.tile_id.easting_idx() - first.easting_idx(), 400);
  }
}

TEST(TilesAround, AreNearOneOfThePlaces) {
  const TileId first = TileId::Containing(kPlace);
  const RowOfTiles row(first, 100, CodebookId(1));
  const Geodetic far = first.WithIndices(first.easting_idx() + 50, first.northing_idx()).Anchor();
  std::vector<int> found;
  for (const TileRecord& tile :
       TilesAround(row, {kPlace, far}, 1.2 * TileId::kSideM).FindTiles(WholeEarth())) {
    found.push_back(tile.tile_id.easting_idx() - first.easting_idx());
  }
  EXPECT_THAT(found, ::testing::ElementsAre(0, 1, 49, 50, 51));
}

TEST(TilesAround, AreNoneOfAnotherCodebook) {
  const RowOfTiles row(TileId::Containing(kPlace), 5, CodebookId(2));
  EXPECT_TRUE(TilesAround(row, {kPlace}, 1e6).empty());
}

TEST(DistanceToMapM, IsThatOfTheNearestPlaceAndTile) {
  const TileId first = TileId::Containing(kPlace);
  const RowOfTiles row(first, 5, CodebookId(1));
  const auto at = [&](int tiles_to_the_west) {
    return first.WithIndices(first.easting_idx() - tiles_to_the_west, first.northing_idx())
        .Anchor();
  };
  EXPECT_NEAR(*DistanceToMapM(row, {at(300), at(50)}), 49.5 * TileId::kSideM,
              0.01 * 50 * TileId::kSideM);
  EXPECT_EQ(*DistanceToMapM(row, {at(0)}), 0.0);
  EXPECT_FALSE(DistanceToMapM(row, {}));
  EXPECT_FALSE(DistanceToMapM(RowOfTiles(first, 0, CodebookId(1)), {kPlace}));
}

}  // namespace
}  // namespace cairn
