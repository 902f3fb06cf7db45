#include "engine/tiles/fetch_tiles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <latch>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "core/error.h"
#include "core/shared_workers.h"
#include "engine/tiles/tile_finisher.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/tile/tile_codec.h"
#include "support/map_builder.h"
#include "support/temp_dir.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using testing::ErrorCodeOf;
using ::testing::IsEmpty;
using testing::RandomTile;

// A map of squares in a row from west to east, each 150 m wide, with keyframes at heights of 100 to
// 110 m.
class FetchTilesTest : public ::testing::Test {
 protected:
  static constexpr int kNumTiles = 4;

  static IndexOptions IndexInTwoParts() {
    IndexOptions options;
    options.grids.num_grids = 2;
    return options;
  }

  FetchTilesTest()
      : store_(MapStore::Create(dir_.File("map.gpkg"))), cache_(1 << 26, IndexInTwoParts()) {
    MapUpdate update = store_.BeginUpdate();
    const CodebookId codebook_id = update.AddCodebook(testing::RandomCodebook());
    for (int i = 0; i < kNumTiles; ++i) {
      const Tile tile = RandomTile(
          {.id = TileInRow(i), .codebook_id = codebook_id, .seed = static_cast<uint64_t>(i)});
      testing::AddTile(tile, &update);
    }
    update.Publish();
  }

  static TileId TileInRow(int i) {
    const TileId first = TileId::Containing(Geodetic::FromDegrees(49.011, 8.416, 0.0));
    return first.WithIndices(first.easting_idx() + i, first.northing_idx());
  }

  // A disc about a point `east_m` of the anchor of the first tile.
  static SearchRegion Disc(double east_m, double radius_m) {
    SearchRegion region;
    region.origin =
        GeodeticFromEcef(EcefFromEnu(TileInRow(0).Anchor()) * Eigen::Vector3d(east_m, 0.0, 0.0));
    region.origin.h_m = 0.0;
    region.ecef_from_anchor = EcefFromEnu(region.origin);
    region.has_prior = true;
    region.prior_sigma_m = 10.0;
    region.radius_m = radius_m;
    return region;
  }

  std::vector<TileView> Fetch(SearchRegion* region, const TilesOptions& options = {},
                              const StopFunction& should_stop = {}) {
    fetched_ = FetchTiles(SnapshotTiles(store_.Snapshot()), *region, options, &cache_, should_stop);
    *region = fetched_.region;
    return fetched_.views;
  }

  static std::vector<TileId> Ids(const std::vector<TileView>& views) {
    std::vector<TileId> ids;
    for (const TileView& view : views) {
      ids.push_back(view.tile->id());
    }
    return ids;
  }

  // Puts a payload in its place that does not decode.
  void DamageTile(int i) {
    MapUpdate update = store_.BeginUpdate();
    const Tile tile = RandomTile({.id = TileInRow(i)});
    std::vector<uint8_t> payload = EncodeTile(tile);
    payload.back() ^= 1;
    update.PutTile(testing::RecordOf(tile), payload);
    update.Publish();
  }

  testing::TempDir dir_;
  MapStore store_;
  TileCache cache_;
  FetchedTiles fetched_;
};

TEST_F(FetchTilesTest, ReturnsTilesThatMeetTheDiscNearestFirst) {
  // 60 m east of the first tile's center: 15 m from the second square, 165 m from the third, and
  // the grid's north deviates from true north by less than 2 m over that distance.
  SearchRegion region = Disc(60.0, 100.0);
  EXPECT_THAT(Ids(Fetch(&region)), ElementsAre(TileInRow(0), TileInRow(1)));
  region = Disc(60.0, 10.0);
  EXPECT_THAT(Ids(Fetch(&region)), ElementsAre(TileInRow(0)));
  region = Disc(90.0, 20.0);
  EXPECT_THAT(Ids(Fetch(&region)), ElementsAre(TileInRow(1), TileInRow(0)));
  region = Disc(60.0, 200.0);
  EXPECT_THAT(Ids(Fetch(&region)), ElementsAre(TileInRow(0), TileInRow(1), TileInRow(2)));
}

TEST_F(FetchTilesTest, RespectsTheLimitAndSaysSo) {
  SearchRegion region = Disc(60.0, 200.0);
  EXPECT_EQ(Ids(Fetch(&region, {.max_tiles = 2})), (std::vector{TileInRow(0), TileInRow(1)}));
  EXPECT_EQ(fetched_.num_found, 3);
  EXPECT_EQ(std::ssize(fetched_.views), 2);
  EXPECT_TRUE(fetched_.limit_hit);
  Fetch(&region, {.max_tiles = 3});
  EXPECT_FALSE(fetched_.limit_hit);
}

TEST_F(FetchTilesTest, FarFromTheMapFindsNothingAndLeavesTheHeightsOpen) {
  SearchRegion region = Disc(5000.0, 100.0);
  const double min_z_m = region.min_z_m;
  EXPECT_THAT(Fetch(&region), IsEmpty());
  EXPECT_EQ(fetched_.num_found, 0);
  EXPECT_EQ(region.min_z_m, min_z_m);
}

TEST_F(FetchTilesTest, LoadsEachTileOnceAndCountsDescriptors) {
  SearchRegion region = Disc(0.0, 50.0);
  const auto first = Fetch(&region);
  EXPECT_EQ(fetched_.num_loaded, 1);
  EXPECT_EQ(fetched_.num_descriptors, static_cast<int64_t>(first[0].tile->num_descriptors()));
  const auto again = Fetch(&region);
  EXPECT_EQ(fetched_.num_loaded, 0);
  EXPECT_EQ(again[0].tile, first[0].tile);
}

TEST_F(FetchTilesTest, LoadsSeveralMissingTilesOnceEachInOrder) {
  SearchRegion region = Disc(0.0, 1'000.0);
  const auto first = Fetch(&region);
  EXPECT_EQ(fetched_.num_loaded, kNumTiles);
  ASSERT_EQ(first.size(), size_t{kNumTiles});
  for (int i = 0; i < kNumTiles; ++i) {
    EXPECT_EQ(first[i].tile->id(), TileInRow(i));
  }
  Fetch(&region);
  EXPECT_EQ(fetched_.num_loaded, 0);
}

TEST_F(FetchTilesTest, ToldToStopItTakesTheNearestTileWithAFirstPartOfItsIndex) {
  const auto stop = [] { return true; };
  SearchRegion region = Disc(60.0, 200.0);
  const auto cut = Fetch(&region, {}, stop);
  ASSERT_THAT(Ids(cut), ElementsAre(TileInRow(0)));
  EXPECT_FALSE(cut[0].tile->index().is_complete());
  EXPECT_FALSE(fetched_.is_complete);
  EXPECT_EQ(fetched_.num_found, 3);
  EXPECT_EQ(std::ssize(fetched_.views), 1);
  EXPECT_FALSE(fetched_.limit_hit);

  const auto whole = Fetch(&region);
  ASSERT_EQ(whole.size(), 3u);
  EXPECT_EQ(whole[0].tile, cut[0].tile);
  for (const TileView& view : whole) {
    EXPECT_TRUE(view.tile->index().is_complete());
  }
  EXPECT_TRUE(fetched_.is_complete);
  EXPECT_EQ(fetched_.num_loaded, 2);

  // What is in the cache costs no time.
  EXPECT_EQ(Fetch(&region, {}, stop).size(), 3u);
  EXPECT_TRUE(fetched_.is_complete);
}

TEST_F(FetchTilesTest, AQueryIsServedWhileAnotherBuildsTheIndex) {
  std::latch is_building(1), may_go_on(1);
  std::vector<TileView> paused;
  std::jthread builder([&] {
    // Pauses when the first part stands.
    const auto pause = [&] {
      is_building.count_down();
      may_go_on.wait();
      return true;
    };
    paused =
        FetchTiles(SnapshotTiles(store_.Snapshot()), Disc(0.0, 50.0), {}, &cache_, pause).views;
  });
  is_building.wait();
  SearchRegion region = Disc(0.0, 50.0);
  const auto hasty = Fetch(&region, {}, [] { return true; });
  EXPECT_FALSE(fetched_.is_complete);
  ASSERT_EQ(hasty.size(), 1u);
  std::vector<DescriptorHit> some, all;
  const DescriptorMatrix queries = DescriptorCodec(store_.Snapshot().CurrentCodebook())
                                       .Decode(hasty[0].tile->codes().data(), 100);
  hasty[0].tile->index().RangeSearch(queries, 10.0, &some);
  EXPECT_GE(some.size(), 100u);
  const auto patient = Fetch(&region);
  EXPECT_TRUE(fetched_.is_complete);
  EXPECT_EQ(fetched_.num_loaded, 0);
  EXPECT_TRUE(patient[0].tile->index().is_complete());
  patient[0].tile->index().RangeSearch(queries, 10.0, &all);
  EXPECT_GT(all.size(), some.size());
  may_go_on.count_down();
  builder.join();
  EXPECT_EQ(paused[0].tile, patient[0].tile);
}

class TileFinisherTest : public FetchTilesTest {
 protected:
  // Of a query in a hurry.
  std::vector<TileView> FetchLittle(SearchRegion region) {
    return Fetch(&region, {}, [] { return true; });
  }

  TilesOptions options_;
  const TileFinisher::ReadLatestTiles read_latest_ = [this](const auto& read) {
    read(SnapshotTiles(store_.Snapshot()));
  };
  SharedWorkers workers_{2};
  TileFinisher finisher_{read_latest_, &cache_, &options_, &workers_};
};

TEST_F(TileFinisherTest, LoadsTilesThatWereLeftOutAndCompletesIndices) {
  const SearchRegion region = Disc(60.0, 200.0);
  const auto few = FetchLittle(region);
  ASSERT_THAT(Ids(few), ElementsAre(TileInRow(0)));
  ASSERT_FALSE(few[0].tile->index().is_complete());
  finisher_.Add(region);
  while (FetchLittle(region).size() < 3 || !fetched_.is_complete) {
    EXPECT_EQ(fetched_.num_loaded, 0);
    std::this_thread::yield();
  }
  EXPECT_TRUE(few[0].tile->index().is_complete());
}

TEST_F(TileFinisherTest, GoesOnAfterARegionThatCannotBeLoaded) {
  const SearchRegion damaged = Disc(60.0, 200.0), sound = Disc(450.0, 10.0);
  DamageTile(1);
  finisher_.Add(damaged);
  finisher_.Add(sound);
  while (FetchLittle(sound).empty() || !fetched_.is_complete) {
    std::this_thread::yield();
  }
}

TEST_F(TileFinisherTest, EndsWithoutWorkAndWithWorkLeft) {
  const TileFinisher idle(read_latest_, &cache_, &options_, &workers_);
  for (size_t i = 0; i < 2 * TileFinisher::kMaxWaiting; ++i) {
    finisher_.Add(Disc(0.0, 50.0));
  }
}

TEST_F(FetchTilesTest, MovesTilesIntoTheAnchorFrame) {
  SearchRegion region = Disc(60.0, 20.0);
  for (const TileView& view : Fetch(&region)) {
    const Eigen::Vector3d x_in_tile(10.0, 20.0, 30.0);
    const Eigen::Vector3d expected =
        region.ecef_from_anchor.Inverse() * (EcefFromEnu(view.tile->id().Anchor()) * x_in_tile);
    EXPECT_LT((view.anchor_from_tile * x_in_tile - expected).norm(), 1e-6);
  }
}

TEST_F(FetchTilesTest, SetsTheHeightsFromTheKeyframesAndTheMargin) {
  SearchRegion region = Disc(0.0, 50.0);
  Fetch(&region, {.height_margin_m = 8.0});
  EXPECT_NEAR(region.min_z_m, 92.0, 0.01);
  EXPECT_NEAR(region.max_z_m, 118.0, 0.01);
}

TEST_F(FetchTilesTest, NarrowsThePriorsHeights) {
  SearchRegion region = Disc(0.0, 50.0);
  region.min_z_m = 105.0;
  region.max_z_m = 500.0;
  Fetch(&region, {.height_margin_m = 8.0});
  EXPECT_NEAR(region.min_z_m, 105.0, 1e-9);
  EXPECT_NEAR(region.max_z_m, 118.0, 0.01);
}

TEST_F(FetchTilesTest, DropsAHeightPriorThatContradictsTheMap) {
  SearchRegion region = Disc(0.0, 50.0);
  region.min_z_m = 40.0;
  region.max_z_m = 60.0;
  Fetch(&region, {.height_margin_m = 8.0});
  EXPECT_NEAR(region.min_z_m, 92.0, 0.01);
  EXPECT_NEAR(region.max_z_m, 118.0, 0.01);
}

TEST_F(FetchTilesTest, RefusesAPayloadThatIsAnotherTile) {
  MapUpdate update = store_.BeginUpdate();
  const Tile tile = RandomTile({.id = TileInRow(0)});
  TileRecord record = testing::RecordOf(tile);
  record.tile_id = TileInRow(1);
  update.PutTile(record, EncodeTile(tile));
  update.Publish();
  SearchRegion region = Disc(150.0, 20.0);
  EXPECT_EQ(ErrorCodeOf([&] { Fetch(&region); }), ErrorCode::kMapDamaged);
}

TEST_F(FetchTilesTest, RefusesTilesOfAnOldCodebook) {
  MapUpdate update = store_.BeginUpdate();
  update.AddCodebook(testing::RandomCodebook({.seed = 2}));
  update.Publish();
  SearchRegion region = Disc(0.0, 50.0);
  EXPECT_EQ(ErrorCodeOf([&] { Fetch(&region); }), ErrorCode::kMapDamaged);
}

TEST_F(FetchTilesTest, NamesTheTileWhosePayloadDoesNotDecode) {
  DamageTile(1);
  SearchRegion region = Disc(150.0, 20.0);
  try {
    Fetch(&region);
    FAIL() << "took a damaged payload";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kMapDamaged);
    EXPECT_THAT(error.what(), ::testing::HasSubstr(TileInRow(1).ToString()));
  }
}

}  // namespace
}  // namespace cairn
