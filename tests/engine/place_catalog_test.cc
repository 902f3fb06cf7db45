#include "engine/places/place_catalog.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "storage/tile/tile_codec.h"
#include "support/map_builder.h"
#include "support/temp_dir.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

// A map of tiles from west to east, `kStep` squares apart, so that neighbors are in two segments.
class PlaceCatalogTest : public ::testing::Test {
 protected:
  static constexpr int kNumTiles = 6, kStep = 16;

  PlaceCatalogTest() : store_(MapStore::Create(dir_.File("map.gpkg"))) {
    MapUpdate update = store_.BeginUpdate();
    codebook_id_ = update.AddCodebook(testing::RandomCodebook());
    for (int i = 0; i < kNumTiles; ++i) {
      testing::AddTile(TileNumber(i, 1), &update);
    }
    update.Publish();
  }

  Tile TileNumber(int i, uint64_t seed) const {
    const TileId first = TileId::Containing(Geodetic::FromDegrees(49.011, 8.416, 0.0));
    return testing::RandomTile(
        {.id = first.WithIndices(first.easting_idx() + i * kStep, first.northing_idx()),
         .codebook_id = codebook_id_,
         .seed = seed * 1000 + static_cast<uint64_t>(i)});
  }

  static CataloguedPlaces IndexOf(const MapSnapshot& snapshot, PlaceCatalog* catalog,
                                  const StopFunction& should_stop = {}) {
    return catalog->IndexOf(SnapshotTiles(snapshot), snapshot.version(), should_stop);
  }

  testing::TempDir dir_;
  MapStore store_;
  CodebookId codebook_id_{};
  PlacesOptions options_;
};

TEST_F(PlaceCatalogTest, HasAllTilesOfTheMap) {
  PlaceCatalog catalog(&options_);
  const CataloguedPlaces places = IndexOf(store_.Snapshot(), &catalog);
  EXPECT_TRUE(places.is_complete);
  EXPECT_EQ(places.index->num_tiles(), size_t{kNumTiles});
  EXPECT_EQ(places.index->segments().size(), size_t{kNumTiles});
}

TEST_F(PlaceCatalogTest, AVersionIsReadOnce) {
  PlaceCatalog catalog(&options_);
  const MapSnapshot snapshot = store_.Snapshot();
  const auto index = IndexOf(snapshot, &catalog).index;
  const int64_t num_calls = store_.Stats().num_calls;
  EXPECT_EQ(IndexOf(snapshot, &catalog).index, index);
  EXPECT_EQ(store_.Stats().num_calls, num_calls);
}

TEST_F(PlaceCatalogTest, AnUpdateRebuildsOnlyWhatItChanged) {
  PlaceCatalog catalog(&options_);
  const auto before = IndexOf(store_.Snapshot(), &catalog).index;
  MapUpdate update = store_.BeginUpdate();
  testing::AddTile(TileNumber(2, 9), &update);
  update.RemoveTile(TileNumber(4, 1).id);
  update.Publish();
  const auto after = IndexOf(store_.Snapshot(), &catalog).index;
  ASSERT_EQ(after->segments().size(), size_t{kNumTiles - 1});
  EXPECT_EQ(after->segments()[1], before->segments()[1]);
  EXPECT_NE(after->segments()[2], before->segments()[2]);
  EXPECT_EQ(after->segments()[3], before->segments()[3]);
  EXPECT_EQ(after->segments()[4], before->segments()[5]);
}

TEST_F(PlaceCatalogTest, OfTheSameContentItIsTheSame) {
  PlaceCatalog one(&options_), other(&options_);
  const auto first = IndexOf(store_.Snapshot(), &one).index;
  const auto second = IndexOf(store_.Snapshot(), &other).index;
  QueryContext photo;
  photo.descriptors = DescriptorMatrix::Random(200, 16);
  photo.keypoints.resize(200);
  photo.rays_in_cam.resize(200, Eigen::Vector3d::UnitZ());
  photo.gravity_orientations_rad.resize(200);
  const auto ranked = first->Rank(photo, options_), again = second->Rank(photo, options_);
  ASSERT_EQ(ranked.size(), again.size());
  for (size_t i = 0; i < ranked.size(); ++i) {
    EXPECT_EQ(ranked[i].score, again[i].score);
    EXPECT_EQ(ranked[i].center.lat_rad, again[i].center.lat_rad);
  }
}

TEST_F(PlaceCatalogTest, StaysWithinItsMemory) {
  const Codebook codebook = testing::RandomCodebook();
  options_.max_bytes = 100 * PlaceSegment::BytesPerDescriptor(codebook) * kNumTiles;
  PlaceCatalog catalog(&options_);
  const auto index = IndexOf(store_.Snapshot(), &catalog).index;
  for (const SharedSegment& segment : index->segments()) {
    EXPECT_EQ(segment->num_descriptors(), 64u);  // 16,384, halved until it is at most 100.
  }
}

TEST_F(PlaceCatalogTest, ToldToStopItGoesOnWithTheNextCall) {
  PlaceCatalog catalog(&options_);
  const CataloguedPlaces stopped = IndexOf(store_.Snapshot(), &catalog, [] { return true; });
  EXPECT_FALSE(stopped.is_complete);
  EXPECT_EQ(stopped.index->num_tiles(), 0u);
  const CataloguedPlaces places = IndexOf(store_.Snapshot(), &catalog);
  EXPECT_TRUE(places.is_complete);
  EXPECT_EQ(places.index->num_tiles(), size_t{kNumTiles});
}

TEST_F(PlaceCatalogTest, AnEmptyMapHasNone) {
  const MapStore empty = MapStore::Create(dir_.File("empty.gpkg"));
  PlaceCatalog catalog(&options_);
  EXPECT_EQ(IndexOf(empty.Snapshot(), &catalog).index, nullptr);
}

TEST_F(PlaceCatalogTest, NamesADamagedTile) {
  const Tile tile = TileNumber(3, 5);
  std::vector<uint8_t> payload = EncodeTile(tile);
  payload.back() ^= 1;
  MapUpdate update = store_.BeginUpdate();
  update.PutTile(testing::RecordOf(tile), payload);
  update.Publish();
  PlaceCatalog catalog(&options_);
  testing::ExpectError([&] { IndexOf(store_.Snapshot(), &catalog); }, ErrorCode::kMapDamaged,
                       tile.id.ToString());
}

}  // namespace
}  // namespace cairn
