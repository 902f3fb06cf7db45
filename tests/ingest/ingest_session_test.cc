#include "ingest/ingest_session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/error.h"
#include "core/frames.h"
#include "ingest/maps/remove_session.h"
#include "storage/tile/tile_codec.h"
#include "support/map_builder.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using testing::ErrorCodeOf;
using testing::SessionNamed;
using testing::ShortStreet;

std::vector<Tile> DecodeAll(const MapStore& store) {
  const MapSnapshot snapshot = store.Snapshot();
  std::vector<Tile> tiles;
  for (const TileRecord& record : snapshot.AllTiles(1000)) {
    tiles.push_back(DecodeTile(snapshot.LoadPayload(record.payload_id)));
  }
  return tiles;
}

// What a tile holds apart from the ids, which a map never gives out twice.
using StoredTile = std::tuple<TileId, std::vector<uint8_t>, std::vector<uint8_t>,
                              std::vector<uint32_t>, std::vector<uint32_t>>;
std::vector<StoredTile> ContentsOf(const MapStore& store) {
  std::vector<StoredTile> contents;
  for (const Tile& tile : DecodeAll(store)) {
    contents.emplace_back(tile.id, tile.codes, tile.orientation_codes, tile.descriptor_begin,
                          tile.keyframe_landmarks);
  }
  return contents;
}

class IngestSessionTest : public ::testing::Test {
 protected:
  IngestSessionTest() : store_(MapStore::Create(dir_.File("map.gpkg"))) {}

  IngestReport Ingest(const testing::StreetWorld& world, const IngestOptions& options) {
    return IngestSession(world.Reconstruct(), world.EcefFromWorld(), options, &store_, {});
  }

  // Landmarks of the map in the street before x_m.
  int64_t CountBefore(double x_m, const testing::StreetWorldOptions& street) const {
    int64_t count = 0;
    for (const Tile& tile : DecodeAll(store_)) {
      const Rigid3d enu_from_tile =
          EcefFromEnu(street.origin).Inverse() * EcefFromEnu(tile.id.Anchor());
      count += std::count_if(tile.x_in_tile.begin(), tile.x_in_tile.end(), [&](const auto& x) {
        return (enu_from_tile * x.template cast<double>()).x() < x_m;
      });
    }
    return count;
  }

  testing::TempDir dir_;
  MapStore store_;
};

TEST_F(IngestSessionTest, WritesLandmarksWhereTheyAre) {
  const testing::StreetWorld world(ShortStreet());
  const IngestReport report = Ingest(world, SessionNamed("first"));
  const Rigid3d enu_from_ecef = EcefFromEnu(world.options().origin).Inverse();
  int64_t num_landmarks = 0;
  for (const Tile& tile : DecodeAll(store_)) {
    const Rigid3d enu_from_tile = enu_from_ecef * EcefFromEnu(tile.id.Anchor());
    for (const Eigen::Vector3f& x_in_tile : tile.x_in_tile) {
      const Eigen::Vector3d x_in_enu = enu_from_tile * x_in_tile.cast<double>();
      double nearest_m = std::numeric_limits<double>::infinity();
      for (const testing::StreetLandmark& landmark : world.landmarks()) {
        nearest_m = std::min(nearest_m, (landmark.x_in_enu - x_in_enu).norm());
      }
      ASSERT_LT(nearest_m, 0.01);
    }
    num_landmarks += static_cast<int64_t>(tile.num_landmarks());
  }
  EXPECT_EQ(num_landmarks, report.num_landmarks_written);
  EXPECT_GT(num_landmarks, 300);
}

TEST_F(IngestSessionTest, TilesHoldWhatTheirOwnKeyframesSee) {
  const testing::StreetWorld world(ShortStreet());
  Ingest(world, SessionNamed("first"));
  size_t num_keyframes = 0;
  for (const Tile& tile : DecodeAll(store_)) {
    const Rigid3d ecef_from_tile = EcefFromEnu(tile.id.Anchor());
    std::set<uint32_t> seen(tile.keyframe_landmarks.begin(), tile.keyframe_landmarks.end());
    EXPECT_EQ(seen.size(), tile.num_landmarks());
    for (const TileKeyframe& keyframe : tile.keyframes) {
      const Geodetic position =
          GeodeticFromEcef(ecef_from_tile * keyframe.cam_from_tile.Inverse().translation);
      EXPECT_EQ(TileId::Containing(position), tile.id);
    }
    for (size_t k = 0; k < tile.num_keyframes(); ++k) {
      for (const uint32_t i : tile.LandmarksOfKeyframe(k)) {
        const Eigen::Vector3d x_in_cam =
            tile.keyframes[k].cam_from_tile * tile.x_in_tile[i].cast<double>();
        EXPECT_TRUE(world.camera().Project(x_in_cam).has_value());
      }
    }
    num_keyframes += tile.num_keyframes();
  }
  EXPECT_EQ(num_keyframes, 16u);
}

TEST_F(IngestSessionTest, AttributesAreThoseOfTheLandmarks) {
  const testing::StreetWorld world(ShortStreet());
  IngestOptions options = SessionNamed("first");
  options.appearance.max_count = 1;
  Ingest(world, options);
  const Rigid3d enu_from_ecef = EcefFromEnu(world.options().origin).Inverse();
  for (const Tile& tile : DecodeAll(store_)) {
    const Rigid3d enu_from_tile = enu_from_ecef * EcefFromEnu(tile.id.Anchor());
    for (size_t i = 0; i < tile.num_landmarks(); ++i) {
      const Eigen::Vector3d x_in_enu = enu_from_tile * tile.x_in_tile[i].cast<double>();
      const auto landmark = std::min_element(
          world.landmarks().begin(), world.landmarks().end(), [&](const auto& a, const auto& b) {
            return (a.x_in_enu - x_in_enu).norm() < (b.x_in_enu - x_in_enu).norm();
          });
      const double orientation_rad = OrientationFromCode(tile.orientation_codes[i]);
      EXPECT_NEAR(WrapAngleRad(orientation_rad - landmark->rectified_orientation_rad), 0.0, 0.05);
      // Half a step of the codes, 9 %.
      EXPECT_NEAR(std::log(SizeFromCode(tile.size_codes[i]) / landmark->size_m), 0.0, 0.09);
      // Seen from the street: the camera lies south of the northern facade.
      EXPECT_LT(std::sin(AzimuthFromCode(tile.azimuth_codes[i])) * x_in_enu.y(), 0.0);
      EXPECT_LE(SigmaFromCode(tile.sigma_codes[i]), options.max_sigma_m * 1.05);
    }
  }
}

TEST_F(IngestSessionTest, RecordsDescribeTheTiles) {
  const testing::StreetWorld world(ShortStreet());
  const IngestReport report = Ingest(world, SessionNamed("first"));
  const MapSnapshot snapshot = store_.Snapshot();
  EXPECT_EQ(snapshot.version(), report.map_version);
  int64_t num_bytes = 0;
  for (const TileRecord& record : snapshot.AllTiles(1000)) {
    const Tile tile = DecodeTile(snapshot.LoadPayload(record.payload_id));
    EXPECT_EQ(record.num_landmarks, static_cast<int64_t>(tile.num_landmarks()));
    EXPECT_NEAR(record.min_h_m, 409.6, 0.1);
    EXPECT_NEAR(record.max_h_m, 409.6, 0.1);
    const Rigid3d ecef_from_tile = EcefFromEnu(tile.id.Anchor());
    for (const Eigen::Vector3f& x_in_tile : tile.x_in_tile) {
      const Geodetic position = GeodeticFromEcef(ecef_from_tile * x_in_tile.cast<double>());
      EXPECT_GE(position.lat_rad, record.landmark_bounds.south_rad - 1e-12);
      EXPECT_LE(position.lat_rad, record.landmark_bounds.north_rad + 1e-12);
      EXPECT_GE(position.lon_rad, record.landmark_bounds.west_rad - 1e-12);
      EXPECT_LE(position.lon_rad, record.landmark_bounds.east_rad + 1e-12);
    }
    num_bytes += record.num_bytes;
  }
  EXPECT_EQ(num_bytes, report.num_payload_bytes);
  const auto session = snapshot.FindSession("first");
  ASSERT_TRUE(session.has_value());
  EXPECT_EQ(session->num_images, 16);
  EXPECT_EQ(snapshot.KeyframesOfSession(session->id).size(), 16u);
  EXPECT_TRUE(store_.Check({}).problems.empty());
}

TEST_F(IngestSessionTest, ALandmarkKeepsItsIdInEveryTile) {
  testing::StreetWorldOptions street = ShortStreet();
  street.length_m = 150.0;  // Longer than a tile.
  street.num_landmarks = 1500;
  const testing::StreetWorld world(street);
  Ingest(world, SessionNamed("first"));
  std::map<LandmarkId, Eigen::Vector3d> place_of_id;
  int num_shared = 0;
  const std::vector<Tile> tiles = DecodeAll(store_);
  ASSERT_GE(tiles.size(), 2u);
  for (const Tile& tile : tiles) {
    const Rigid3d ecef_from_tile = EcefFromEnu(tile.id.Anchor());
    for (size_t i = 0; i < tile.num_landmarks(); ++i) {
      const Eigen::Vector3d x_in_ecef = ecef_from_tile * tile.x_in_tile[i].cast<double>();
      const auto [found, is_new] = place_of_id.emplace(tile.landmark_ids[i], x_in_ecef);
      num_shared += !is_new;
      EXPECT_LT((found->second - x_in_ecef).norm(), 0.01);
    }
  }
  EXPECT_GT(num_shared, 10);
}

TEST_F(IngestSessionTest, IngestingAgainReplacesTheSession) {
  const testing::StreetWorld world(ShortStreet());
  const IngestReport first = Ingest(world, SessionNamed("same"));
  const std::vector<StoredTile> contents = ContentsOf(store_);
  IngestOptions recorded = SessionNamed("same");
  recorded.recorded_at = "2020-01-01T00:00:00Z";
  const IngestReport second = Ingest(world, recorded);
  EXPECT_FALSE(first.replaced_session);
  EXPECT_TRUE(second.replaced_session);
  EXPECT_EQ(ContentsOf(store_), contents);
  EXPECT_EQ(store_.Snapshot().Sessions().size(), 1u);
  EXPECT_EQ(store_.Snapshot().Info().num_keyframes, 16);
  EXPECT_EQ(Value(second.map_version), Value(first.map_version) + 1);
}

TEST_F(IngestSessionTest, ReplacingEmptiesTilesTheNewSessionDoesNotReach) {
  Ingest(testing::StreetWorld(ShortStreet()), SessionNamed("moving"));
  const std::vector<Tile> before = DecodeAll(store_);
  testing::StreetWorldOptions elsewhere = ShortStreet();
  elsewhere.origin = Geodetic::FromDegrees(47.4, 8.6, 408.0);
  Ingest(testing::StreetWorld(elsewhere), SessionNamed("moving"));
  for (const Tile& tile : before) {
    EXPECT_FALSE(store_.Snapshot().FindTile(tile.id).has_value());
  }
  EXPECT_GT(store_.Snapshot().Info().num_tiles, 0);
}

TEST_F(IngestSessionTest, SessionsShareTilesAndOneCanBeRemoved) {
  const testing::StreetWorld world(ShortStreet());
  Ingest(world, SessionNamed("monday"));
  const std::vector<StoredTile> alone = ContentsOf(store_);
  const int64_t num_alone = store_.Snapshot().Info().num_landmarks;
  testing::StreetWorldOptions other_day = ShortStreet();
  other_day.view_seed = 77;
  IngestOptions apart = SessionNamed("tuesday");
  apart.joining = SessionJoining::kApart;
  Ingest(testing::StreetWorld(other_day), apart);
  EXPECT_GT(store_.Snapshot().Info().num_landmarks, num_alone * 19 / 10);
  EXPECT_EQ(store_.Snapshot().Info().num_keyframes, 32);
  EXPECT_TRUE(store_.Check({}).problems.empty());

  RemoveSession("tuesday", &store_);
  EXPECT_EQ(ContentsOf(store_), alone);
  RemoveSession("monday", &store_);
  EXPECT_EQ(store_.Snapshot().Info().num_tiles, 0);
  EXPECT_EQ(store_.Snapshot().Info().num_keyframes, 0);
  EXPECT_EQ(ErrorCodeOf([&] { RemoveSession("monday", &store_); }), ErrorCode::kNotFound);
}

TEST_F(IngestSessionTest, ASecondVisitUpdatesWhatTheMapKnows) {
  Ingest(testing::StreetWorld(ShortStreet()), SessionNamed("monday"));
  const MapInfo before = store_.Snapshot().Info();
  testing::StreetWorldOptions other_day = ShortStreet();
  other_day.view_seed = 77;
  const IngestReport report = Ingest(testing::StreetWorld(other_day), SessionNamed("tuesday"));
  const MapInfo after = store_.Snapshot().Info();
  EXPECT_GT(report.comparison.num_localized, 10);
  EXPECT_LT(report.comparison.fit.moved_m, 0.05);
  EXPECT_GT(report.changes.num_merged, before.num_landmarks * 8 / 10);
  EXPECT_LT(after.num_landmarks, before.num_landmarks * 11 / 10);
  EXPECT_EQ(after.num_keyframes, 2 * before.num_keyframes);
  EXPECT_TRUE(store_.Check({}).problems.empty());
}

TEST_F(IngestSessionTest, KeyframesOfAViewpointAreThoseOfTheTwoNewestSessions) {
  testing::StreetWorldOptions street = ShortStreet();
  for (const int day : {1, 2, 3, 4}) {
    street.view_seed = static_cast<uint64_t>(day);
    Ingest(testing::StreetWorld(street), SessionNamed("day " + std::to_string(day)));
  }
  const std::vector<SessionRecord> sessions = store_.Snapshot().Sessions();
  EXPECT_TRUE(store_.Snapshot().KeyframesOfSession(sessions[1].id).empty());
  EXPECT_FALSE(store_.Snapshot().KeyframesOfSession(sessions[2].id).empty());
  const int64_t num_tiles = store_.Snapshot().Info().num_tiles;
  // The newest session can go, and the session that has no keyframe left, too.
  RemoveSession("day 4", &store_);
  const RemovalReport report = RemoveSession("day 2", &store_);
  EXPECT_GT(report.num_landmarks_shared, 0);
  EXPECT_EQ(store_.Snapshot().Info().num_tiles, num_tiles);
  EXPECT_TRUE(store_.Check({}).problems.empty());
  // Then the map has no photo of the place left.
  EXPECT_GT(RemoveSession("day 3", &store_).num_tiles_removed, 0);
  EXPECT_EQ(store_.Snapshot().Info().num_tiles, 0);
  EXPECT_TRUE(store_.Check({}).problems.empty());
}

TEST_F(IngestSessionTest, APlaceThatThreeSessionsKnowKeepsItsSize) {
  testing::StreetWorldOptions street = ShortStreet();
  int64_t bytes_of_three = 0;
  for (int day = 1; day <= 8; ++day) {
    street.view_seed = static_cast<uint64_t>(day);
    const IngestReport report =
        Ingest(testing::StreetWorld(street), SessionNamed("day " + std::to_string(day)));
    const int64_t bytes = store_.Snapshot().Info().payload_bytes;
    bytes_of_three = day == 3 ? bytes : bytes_of_three;
    if (day > 3) {
      EXPECT_GT(report.changes.num_merged, report.changes.num_new);
      EXPECT_LE(bytes, bytes_of_three * 105 / 100);
      EXPECT_GE(bytes, bytes_of_three * 90 / 100);
    }
  }
}

TEST_F(IngestSessionTest, TheSameSessionAgainChangesNothing) {
  const testing::StreetWorld world(ShortStreet());
  Ingest(world, SessionNamed("monday"));
  const MapVersion version = store_.Snapshot().version();
  const IngestReport again = Ingest(world, SessionNamed("monday"));
  EXPECT_TRUE(again.is_unchanged);
  EXPECT_EQ(store_.Snapshot().version(), version);
}

TEST_F(IngestSessionTest, WhatNoLaterSessionSeesGoes) {
  testing::StreetWorldOptions street = ShortStreet();
  IngestOptions options = SessionNamed("2016");
  options.recorded_at = "2016-06-01T00:00:00Z";
  const Reconstruction first = testing::StreetWorld(street).Reconstruct();
  IngestSession(first, testing::StreetWorld(street).EcefFromWorld(), options, &store_, {});
  const int64_t num_gone_before = CountBefore(15.0, street);
  int64_t num_gone = 0;  // Faded, or evicted for what the place has now.
  for (const int year : {2017, 2018, 2019, 2020, 2021}) {
    street.view_seed = static_cast<uint64_t>(year);
    Reconstruction later = testing::StreetWorld(street).Reconstruct();
    // A third of the facade is torn down.
    std::erase_if(later.landmarks, [&](const ReconLandmark& landmark) {
      return (street.world_from_enu.Inverse() * landmark.x_in_world).x() < 20.0;
    });
    options.session_name = std::to_string(year);
    options.recorded_at = std::to_string(year) + "-06-01T00:00:00Z";
    const TileChanges changes =
        IngestSession(later, testing::StreetWorld(street).EcefFromWorld(), options, &store_, {})
            .changes;
    num_gone += changes.num_faded + changes.num_evicted;
  }
  EXPECT_GT(num_gone, num_gone_before / 3);
  EXPECT_LT(CountBefore(15.0, street), num_gone_before / 2);
}

TEST_F(IngestSessionTest, ATileStaysWithinItsBudgetWhateverIsAdded) {
  IngestOptions options = SessionNamed("");
  options.selection.max_descriptors = 300;
  for (const int day : {1, 2, 3}) {
    testing::StreetWorldOptions street = ShortStreet();
    street.view_seed = day;
    options.session_name = "day " + std::to_string(day);
    Ingest(testing::StreetWorld(street), options);
    for (const Tile& tile : DecodeAll(store_)) {
      EXPECT_LE(tile.num_descriptors(), 300u);
      EXPECT_GT(tile.num_descriptors(), 250u);
    }
  }
  // Every day is still there.
  std::set<SessionId> sessions;
  for (const Tile& tile : DecodeAll(store_)) {
    for (const HistoryEntry& entry : tile.history) {
      sessions.insert(entry.session_id);
    }
  }
  EXPECT_EQ(sessions.size(), 3u);
}

TEST_F(IngestSessionTest, DropsLandmarksThatFitBadly) {
  const testing::StreetWorld world(ShortStreet());
  Reconstruction reconstruction = world.Reconstruct();
  const Eigen::Vector3d off =
      world.options().world_from_enu.rotation * Eigen::Vector3d(0.3, 0.3, 0.3);
  for (int i = 0; i < 50; ++i) {
    reconstruction.landmarks[i].x_in_world += off;
  }
  const IngestReport clean = Ingest(world, SessionNamed("clean"));
  IngestOptions options = SessionNamed("bad");
  options.joining = SessionJoining::kApart;  // The photos are the same.
  const IngestReport bad =
      IngestSession(reconstruction, world.EcefFromWorld(), options, &store_, {});
  EXPECT_GE(bad.num_landmarks_dropped, clean.num_landmarks_dropped + 45);
}

TEST_F(IngestSessionTest, ReportsProgressToTheEnd) {
  const testing::StreetWorld world(ShortStreet());
  std::map<std::string, std::pair<int64_t, int64_t>> last;
  IngestSession(world.Reconstruct(), world.EcefFromWorld(), SessionNamed("first"), &store_,
                [&](const char* phase, int64_t done, int64_t total) {
                  EXPECT_GE(done, last[phase].first);
                  EXPECT_LE(done, total);
                  last[phase] = {done, total};
                });
  EXPECT_EQ(last.at("codebook"), (std::pair<int64_t, int64_t>(1, 1)));
  EXPECT_EQ(last.at("tiles").first, last.at("tiles").second);
}

}  // namespace
}  // namespace cairn
