#include "storage/map/extract_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "support/map_place.h"
#include "support/places.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using testing::ErrorCodeOf;
using ::testing::IsEmpty;
using testing::PutPlace;
using testing::RowsOf;
using testing::TileOfPlace;

// A map of five places, of which the places 1 and 3 are extracted by two boxes.
class ExtractedMap : public testing::MapPlaceTest {
 protected:
  void SetUp() override {
    testing::MapPlaceTest::SetUp();
    if (IsSkipped()) {
      return;
    }
    from_ = Place("from");
    to_ = Place("to");
    store_.emplace(MapStore::Create(from_));
    MapUpdate update = store_->BeginUpdate();
    for (int place = 0; place < 5; ++place) {
      PutPlace(place, place, &update);
    }
    update.Publish();
    MapUpdate again = store_->BeginUpdate();
    PutPlace(1, 9, &again);
    again.Publish();
  }

  static GeoRegion AroundPlaces(const std::vector<int>& places) {
    std::vector<GeoPolygon> polygons;
    for (const int place : places) {
      const Geodetic center = TileOfPlace(place).Anchor();
      const double lon = center.lon_deg(), lat = center.lat_deg();
      polygons.push_back({{{lon, lat}, {lon + 1e-5, lat}, {lon, lat + 1e-5}}});
    }
    return GeoRegion::OfPolygons(polygons);
  }

  std::string from_, to_;
  std::optional<MapStore> store_;
};

CAIRN_ON_BOTH_KINDS_OF_MAPS(ExtractedMap);

TEST_P(ExtractedMap, HasTheTilesToTheByteWithTheirKeyframesAndSessions) {
  const MapTotals totals = ExtractMap(*store_, AroundPlaces({1, 3}), to_);
  EXPECT_EQ(totals.num_tiles, 2);
  EXPECT_EQ(totals.num_sessions, 2);
  EXPECT_EQ(totals.num_keyframes, 4);
  const std::string digests =
      "SELECT c.tile, p.digest FROM cairn_tiles AS t JOIN coverage AS c USING (tile_id) "
      "JOIN cairn_payloads AS p USING (payload_id) ";
  EXPECT_EQ(RowsOf(to_, digests + "ORDER BY c.tile"),
            RowsOf(from_, digests + "WHERE c.tile IN ('" + TileOfPlace(1).ToString() + "', '" +
                              TileOfPlace(3).ToString() + "') ORDER BY c.tile"));
  EXPECT_THAT(RowsOf(to_, "SELECT name FROM cairn_sessions ORDER BY name"),
              ElementsAre("place 1", "place 3"));
  const MapStore extracted = MapStore::Open(to_, OpenMode::kReadOnly);
  EXPECT_THAT(extracted.Check({}).problems, IsEmpty());
  const std::vector<VersionRecord> versions = extracted.Snapshot().Versions(9);
  ASSERT_EQ(versions.size(), 2u);
  EXPECT_EQ(versions[0].kind, "extract");
  const bool is_file = GetParam() == testing::MapKind::kFile;
  const std::string name = is_file ? std::filesystem::path(from_).filename().string() : from_;
  EXPECT_EQ(versions[0].summary, "2 of 5 tiles of " + name + ", version 3");
  EXPECT_EQ(extracted.Snapshot().NextLandmarkId(), store_->Snapshot().NextLandmarkId());
}

TEST_P(ExtractedMap, CanBeUpdated) {
  ExtractMap(*store_, AroundPlaces({1}), to_);
  MapStore extracted = MapStore::Open(to_, OpenMode::kReadWrite);
  MapUpdate update = extracted.BeginUpdate();
  PutPlace(1, 5, &update);
  PutPlace(2, 6, &update);
  update.Publish();
  EXPECT_THAT(extracted.Check({}).problems, IsEmpty());
}

TEST_P(ExtractedMap, IsNotMadeOfNothingOrOverAnother) {
  EXPECT_EQ(ErrorCodeOf([&] { ExtractMap(*store_, GeoRegion::OfBox(0, 0, 1, 1), to_); }),
            ErrorCode::kNotFound);
  EXPECT_EQ(ErrorCodeOf([&] { MapStore::Open(to_, OpenMode::kReadOnly); }), ErrorCode::kNotFound);
  EXPECT_EQ(ErrorCodeOf([&] { ExtractMap(*store_, AroundPlaces({1}), from_); }),
            ErrorCode::kConflict);
  EXPECT_EQ(store_->Snapshot().Info().num_tiles, 5);
}

}  // namespace
}  // namespace cairn
