#include "storage/map/map_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "core/angles.h"
#include "core/error.h"
#include "storage/map/describe_tile.h"
#include "storage/tile/tile_codec.h"
#include "support/map_builder.h"
#include "support/map_place.h"
#include "support/street_map.h"
#include "support/temp_dir.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using testing::AddTile;
using testing::BoxDeg;
using ::testing::ElementsAre;
using testing::ErrorCodeOf;
using testing::Ids;
using ::testing::IsEmpty;
using testing::KeyframeAt;
using testing::NamedSession;
using testing::RandomCodebook;
using testing::RandomTile;
using testing::TempDir;
using testing::TileAt;

class MapStoreTest : public testing::MapPlaceTest {};
CAIRN_ON_BOTH_KINDS_OF_MAPS(MapStoreTest);

TEST_P(MapStoreTest, NewMapIsEmpty) {
  const MapStore store = MapStore::Create(Place("a"));
  const MapSnapshot snapshot = store.Snapshot();
  const MapInfo info = snapshot.Info();
  EXPECT_EQ(snapshot.version(), MapVersion(1));
  EXPECT_EQ(info.num_tiles, 0);
  EXPECT_EQ(info.num_sessions, 0);
  EXPECT_EQ(info.payload_bytes, 0);
  EXPECT_FALSE(info.bounds.has_value());
  EXPECT_EQ(info.created_at.size(), std::string("2026-01-01T00:00:00Z").size());
  EXPECT_EQ(snapshot.CurrentCodebook(), nullptr);
  EXPECT_THAT(snapshot.AllTiles(10), IsEmpty());
  EXPECT_THAT(store.Check({}).problems, IsEmpty());
}

TEST(MapStore, CreateRefusesAnExistingFile) {
  const TempDir dir;
  MapStore::Create(dir.File("a.gpkg"));
  EXPECT_EQ(ErrorCodeOf([&] { MapStore::Create(dir.File("a.gpkg")); }), ErrorCode::kConflict);
  EXPECT_EQ(ErrorCodeOf([&] { MapStore::Create(dir.File("none/a.gpkg")); }), ErrorCode::kIo);
}

TEST_P(MapStoreTest, WhatWasPublishedIsReadBack) {
  MapStore store = MapStore::Create(Place("a"));
  const Geodetic position = Geodetic::FromDegrees(49.011, 8.416, 115.0);
  MapUpdate update = store.BeginUpdate();
  const CodebookId codebook_id = update.AddCodebook(RandomCodebook());
  SessionRecord described = NamedSession("drive 1");
  described.source = "kitti";
  described.recorded_at = "2026-01-31T12:00:00Z";
  described.content_digest = "00ff";
  described.num_images = 7;
  described.num_landmarks = 1234;
  described.georef_median_residual_m = 0.25;
  const SessionId session_id = update.AddSession(described);
  const KeyframeRecord written = KeyframeAt(position, session_id);
  const KeyframeId keyframe_id = update.AddKeyframe(written);
  Tile tile = RandomTile({.id = TileId::Containing(position),
                          .codebook_id = codebook_id,
                          .num_keyframes = 1,
                          .first_keyframe_id = Value(keyframe_id),
                          .first_landmark_id = Value(update.ReserveLandmarkIds(100))});
  tile.keyframes[0].cam_from_tile = written.cam_from_ecef * EcefFromEnu(tile.id.Anchor());
  const PayloadId payload_id = update.PutTile(DescribeTile(tile), EncodeTile(tile));
  EXPECT_EQ(update.Publish(), MapVersion(2));

  const MapSnapshot snapshot = MapStore::Open(store.path(), OpenMode::kReadOnly).Snapshot();
  EXPECT_EQ(snapshot.version(), MapVersion(2));
  const std::optional<TileRecord> record = snapshot.FindTile(tile.id);
  ASSERT_TRUE(record.has_value());
  EXPECT_EQ(record->payload_id, payload_id);
  EXPECT_EQ(record->codebook_id, codebook_id);
  EXPECT_EQ(record->num_landmarks, 100);
  EXPECT_NEAR(record->landmark_bounds.west_rad, DescribeTile(tile).landmark_bounds.west_rad, 1e-15);
  EXPECT_TRUE(testing::SameTile(DecodeTile(snapshot.LoadPayload(payload_id)), tile));
  EXPECT_EQ(snapshot.LoadCodebook(codebook_id)->words, RandomCodebook().words);
  EXPECT_EQ(snapshot.CurrentCodebook(), snapshot.LoadCodebook(codebook_id));

  const std::optional<SessionRecord> session = snapshot.FindSession("drive 1");
  ASSERT_TRUE(session.has_value());
  EXPECT_EQ(session->id, session_id);
  EXPECT_EQ(session->source, "kitti");
  EXPECT_EQ(session->recorded_at, "2026-01-31T12:00:00Z");
  EXPECT_EQ(session->content_digest, "00ff");
  EXPECT_EQ(session->num_images, 7);
  EXPECT_EQ(session->num_landmarks, 1234);
  EXPECT_EQ(session->georef_median_residual_m, 0.25);

  const std::vector<KeyframeRecord> keyframes = snapshot.KeyframesOfSession(session_id);
  ASSERT_EQ(keyframes.size(), 1u);
  EXPECT_EQ(keyframes[0].id, keyframe_id);
  EXPECT_EQ(keyframes[0].image_name, written.image_name);
  EXPECT_EQ(keyframes[0].camera.model(), written.camera.model());
  EXPECT_EQ(keyframes[0].camera.params(), written.camera.params());
  EXPECT_EQ(keyframes[0].cam_from_ecef.rotation.coeffs(), written.cam_from_ecef.rotation.coeffs());
  EXPECT_EQ(keyframes[0].cam_from_ecef.translation, written.cam_from_ecef.translation);
  EXPECT_THAT(store.Check({}).problems, IsEmpty());
}

TEST_P(MapStoreTest, InfoCountsAndBounds) {
  MapStore store = MapStore::Create(Place("a"));
  MapUpdate update = store.BeginUpdate();
  update.AddCodebook(RandomCodebook());
  update.AddSession(NamedSession("s"));
  const Tile west = RandomTile({.id = TileAt(-17.0, 179.9)});
  const Tile east = RandomTile({.id = TileAt(-16.0, -179.9)});
  AddTile(west, &update);
  AddTile(east, &update);
  update.Publish();
  const MapInfo info = store.Snapshot().Info();
  EXPECT_EQ(info.num_tiles, 2);
  EXPECT_EQ(info.num_sessions, 1);
  EXPECT_EQ(info.num_landmarks, 200);
  EXPECT_EQ(info.num_descriptors,
            static_cast<int64_t>(west.num_descriptors() + east.num_descriptors()));
  EXPECT_GT(info.file_bytes, info.payload_bytes);
  ASSERT_TRUE(info.bounds.has_value());
  EXPECT_TRUE(info.bounds->CrossesAntimeridian());
  EXPECT_NEAR(info.bounds->west_rad, 179.9 * kRadPerDeg, 1e-4);
  EXPECT_NEAR(info.bounds->east_rad, -179.9 * kRadPerDeg, 1e-4);
}

TEST_P(MapStoreTest, FindTilesReturnsExactlyTheSquaresThatMeetTheBox) {
  MapStore store = MapStore::Create(Place("a"));
  MapUpdate update = store.BeginUpdate();
  update.AddCodebook(RandomCodebook());
  std::vector<TileId> ids;
  for (int row = 0; row < 12; ++row) {
    for (int column = 0; column < 12; ++column) {
      ids.push_back(TileAt(49.0 + row * 0.00135, 8.4 + column * 0.00206));
    }
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  for (const TileId id : ids) {
    AddTile(RandomTile({.id = id, .num_landmarks = 1, .num_keyframes = 0}), &update);
  }
  update.Publish();
  const MapSnapshot snapshot = store.Snapshot();
  EXPECT_EQ(Ids(snapshot.AllTiles(1000)), ids);
  EXPECT_EQ(Ids(snapshot.AllTiles(2)), std::vector<TileId>(ids.begin(), ids.begin() + 2));

  const TileId tile = ids[40];
  const GeoBox bounds = tile.Bounds();
  constexpr double kMillimeterRad = 1e-3 / 6.4e6;
  // Corner to corner: what the index's 32-bit floats cannot tell apart.
  GeoBox just_outside = {bounds.south_rad, bounds.east_rad + kMillimeterRad, bounds.north_rad,
                         bounds.east_rad + 2 * kMillimeterRad};
  GeoBox just_touching = just_outside;
  just_touching.west_rad = bounds.east_rad;
  EXPECT_THAT(Ids(snapshot.FindTiles(just_outside)), ::testing::Not(::testing::Contains(tile)));
  EXPECT_THAT(Ids(snapshot.FindTiles(just_touching)), ::testing::Contains(tile));
  EXPECT_THAT(snapshot.FindTiles(BoxDeg(10, 8, 20, 9)), IsEmpty());
  EXPECT_EQ(Ids(snapshot.FindTiles(BoxDeg(-90, -180, 90, 180))), ids);
}

TEST_P(MapStoreTest, FindTilesAcrossTheAntimeridianAndAtThePoles) {
  MapStore store = MapStore::Create(Place("a"));
  MapUpdate update = store.BeginUpdate();
  update.AddCodebook(RandomCodebook());
  const TileId west = TileAt(-17.0, 179.9995);
  const TileId east = TileAt(-17.0, -179.9995);
  const TileId pole = TileAt(89.9999, 45.0);
  const TileId near_pole = TileAt(89.995, 170.0);
  for (const TileId id : {west, east, pole, near_pole}) {
    AddTile(RandomTile({.id = id, .num_landmarks = 1, .num_keyframes = 0}), &update);
  }
  update.Publish();
  const MapSnapshot snapshot = store.Snapshot();
  const auto find = [&](const Geodetic& center) {
    return Ids(snapshot.FindTiles(BoxAround(center, 200.0)));
  };
  using ::testing::Contains;
  for (const double lon_deg : {179.9995, -179.9995}) {
    const std::vector<TileId> found = find(Geodetic::FromDegrees(-17.0, lon_deg, 0.0));
    EXPECT_THAT(found, Contains(west)) << lon_deg;
    EXPECT_THAT(found, Contains(east)) << lon_deg;
    EXPECT_EQ(found.size(), 2u);
  }
  EXPECT_THAT(find(Geodetic::FromDegrees(89.9999, -135.0, 0.0)), Contains(pole));
  EXPECT_THAT(find(near_pole.Anchor()), Contains(near_pole));
  EXPECT_THAT(find(Geodetic::FromDegrees(-17.0, 0.0, 0.0)), IsEmpty());
}

TEST_P(MapStoreTest, SnapshotKeepsItsVersionWhileAnUpdateIsPublished) {
  MapStore store = MapStore::Create(Place("a"));
  const Tile tile = RandomTile();
  MapUpdate first = store.BeginUpdate();
  first.AddCodebook(RandomCodebook());
  const PayloadId old_payload = AddTile(tile, &first);
  first.Publish();

  const MapSnapshot before = store.Snapshot();
  MapUpdate second = store.BeginUpdate();
  const PayloadId new_payload = AddTile(RandomTile({.seed = 2}), &second);
  EXPECT_EQ(second.FindTile(tile.id)->payload_id, new_payload);
  EXPECT_EQ(store.Snapshot().FindTile(tile.id)->payload_id, old_payload);
  second.Publish();

  const MapSnapshot after = store.Snapshot();
  EXPECT_EQ(before.version(), MapVersion(2));
  EXPECT_EQ(before.FindTile(tile.id)->payload_id, old_payload);
  EXPECT_TRUE(testing::SameTile(DecodeTile(before.LoadPayload(old_payload)), tile));
  EXPECT_EQ(after.version(), MapVersion(3));
  EXPECT_EQ(after.FindTile(tile.id)->payload_id, new_payload);
  // Version 2 still has it.
  EXPECT_TRUE(testing::SameTile(DecodeTile(after.LoadPayload(old_payload)), tile));
}

TEST_P(MapStoreTest, ThreadsReadWholeVersionsWhileUpdatesArePublished) {
  constexpr int kNumUpdates = 15;
  MapStore store = MapStore::Create(Place("a"));
  // Version v of the map holds two tiles of v landmarks each.
  const auto publish = [&store](int num_landmarks) {
    MapUpdate update = store.BeginUpdate();
    if (update.CurrentCodebook() == nullptr) {
      update.AddCodebook(RandomCodebook());
    }
    for (const double lon_deg : {8.4, 8.5}) {
      AddTile(RandomTile({.id = TileAt(49.0, lon_deg), .num_landmarks = num_landmarks}), &update);
    }
    return update.Publish();
  };
  EXPECT_EQ(publish(2), MapVersion(2));
  std::atomic<bool> done = false;
  std::vector<std::thread> readers;
  for (int i = 0; i < 3; ++i) {
    readers.emplace_back([&] {
      bool last_round = false;
      while (!last_round) {
        last_round = done;
        const MapSnapshot snapshot = store.Snapshot();
        const std::vector<TileRecord> tiles = snapshot.AllTiles(10);
        EXPECT_EQ(tiles.size(), 2u);
        for (const TileRecord& tile : tiles) {
          EXPECT_EQ(DecodeTile(snapshot.LoadPayload(tile.payload_id)).num_landmarks(),
                    static_cast<size_t>(Value(snapshot.version())));
        }
        EXPECT_NE(snapshot.CurrentCodebook(), nullptr);
      }
    });
  }
  for (int i = 0; i < kNumUpdates; ++i) {
    publish(3 + i);
  }
  done = true;
  for (std::thread& reader : readers) {
    reader.join();
  }
  EXPECT_EQ(store.Snapshot().version(), MapVersion(2 + kNumUpdates));
}

TEST_P(MapStoreTest, PayloadIdsAreNotUsedAgain) {
  MapStore store = MapStore::Create(Place("a"));
  MapUpdate first = store.BeginUpdate();
  first.AddCodebook(RandomCodebook());
  const PayloadId removed = AddTile(RandomTile(), &first);
  first.RemoveTile(RandomTile().id);
  first.Publish();
  EXPECT_THAT(store.Snapshot().AllTiles(10), IsEmpty());
  MapUpdate second = store.BeginUpdate();
  EXPECT_GT(Value(AddTile(RandomTile(), &second)), Value(removed));
}

TEST_P(MapStoreTest, LandmarkIdsAreReservedInOrder) {
  MapStore store = MapStore::Create(Place("a"));
  MapUpdate update = store.BeginUpdate();
  EXPECT_EQ(update.ReserveLandmarkIds(10), LandmarkId(1));
  EXPECT_EQ(update.ReserveLandmarkIds(0), LandmarkId(11));
  update.Publish();
  EXPECT_EQ(store.BeginUpdate().ReserveLandmarkIds(5), LandmarkId(11));
}

TEST_P(MapStoreTest, AnUpdateThatIsNotPublishedLeavesNothing) {
  MapStore store = MapStore::Create(Place("a"));
  {
    MapUpdate update = store.BeginUpdate();
    update.AddCodebook(RandomCodebook());
    update.AddSession(NamedSession("s"));
    AddTile(RandomTile(), &update);
  }
  const MapSnapshot snapshot = store.Snapshot();
  EXPECT_EQ(snapshot.version(), MapVersion(1));
  EXPECT_THAT(snapshot.AllTiles(10), IsEmpty());
  EXPECT_THAT(snapshot.Sessions(), IsEmpty());
  EXPECT_EQ(snapshot.CurrentCodebook(), nullptr);
}

TEST_P(MapStoreTest, SecondUpdateIsAConflictAtOnce) {
  MapStore store = MapStore::Create(Place("a"));
  MapStore other = MapStore::Open(store.path(), OpenMode::kReadWrite);
  const MapUpdate update = store.BeginUpdate();
  EXPECT_EQ(ErrorCodeOf([&] { store.BeginUpdate(); }), ErrorCode::kConflict);
  EXPECT_EQ(ErrorCodeOf([&] { other.BeginUpdate(); }), ErrorCode::kConflict);
}

TEST_P(MapStoreTest, ReadOnlyStoreRefusesUpdates) {
  MapStore::Create(Place("a"));
  MapStore store = MapStore::Open(Place("a"), OpenMode::kReadOnly);
  EXPECT_EQ(ErrorCodeOf([&] { store.BeginUpdate(); }), ErrorCode::kConflict);
}

TEST_P(MapStoreTest, SessionsAreNamedOnceAndCanBeRemoved) {
  MapStore store = MapStore::Create(Place("a"));
  const Geodetic position = Geodetic::FromDegrees(49.0, 8.4, 100.0);
  MapUpdate update = store.BeginUpdate();
  const SessionId first = update.AddSession(NamedSession("a"));
  const SessionId second = update.AddSession(NamedSession("b"));
  EXPECT_EQ(ErrorCodeOf([&] { update.AddSession(NamedSession("a")); }), ErrorCode::kConflict);
  update.AddKeyframe(KeyframeAt(position, first));
  update.AddKeyframe(KeyframeAt(position, second));
  update.RemoveSession(first);
  EXPECT_FALSE(update.FindSession("a").has_value());
  update.Publish();
  const MapSnapshot snapshot = store.Snapshot();
  EXPECT_EQ(snapshot.Sessions().size(), 1u);
  EXPECT_EQ(snapshot.KeyframesOfSession(second).size(), 1u);
  EXPECT_THAT(store.Check({}).problems, IsEmpty());
}

TEST_P(MapStoreTest, SnapshotOutlivesTheStore) {
  std::optional<MapStore> store = MapStore::Create(Place("a"));
  const MapSnapshot snapshot = store->Snapshot();
  store.reset();
  EXPECT_EQ(snapshot.version(), MapVersion(1));
  EXPECT_THAT(snapshot.AllTiles(1), IsEmpty());
}

TEST(MapStore, ClosingLeavesOneFile) {
  const TempDir dir;
  {
    MapStore store = MapStore::Create(dir.File("a.gpkg"));
    MapUpdate update = store.BeginUpdate();
    update.AddSession(NamedSession("s"));
    update.Publish();
  }
  EXPECT_FALSE(std::filesystem::exists(dir.File("a.gpkg-wal")));
  EXPECT_FALSE(std::filesystem::exists(dir.File("a.gpkg-shm")));
}

}  // namespace
}  // namespace cairn
