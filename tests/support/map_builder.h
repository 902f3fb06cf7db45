// Helpers for tests that fill map files.
#ifndef CAIRN_TESTS_SUPPORT_MAP_BUILDER_H_
#define CAIRN_TESTS_SUPPORT_MAP_BUILDER_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/angles.h"
#include "core/error.h"
#include "core/geodesy.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile.h"
#include "storage/tile/tile_codec.h"
#include "support/expect_error.h"

namespace cairn::testing {

inline TileId TileAt(double lat_deg, double lon_deg) {
  return TileId::Containing(Geodetic::FromDegrees(lat_deg, lon_deg, 0.0));
}

inline GeoBox BoxDeg(double south, double west, double north, double east) {
  return {south * kRadPerDeg, west * kRadPerDeg, north * kRadPerDeg, east * kRadPerDeg};
}

inline std::vector<TileId> Ids(const std::vector<TileRecord>& tiles) {
  std::vector<TileId> ids;
  for (const TileRecord& tile : tiles) {
    ids.push_back(tile.tile_id);
  }
  return ids;
}

inline SessionRecord NamedSession(const std::string& name) {
  SessionRecord session;
  session.name = name;
  return session;
}

// Returns the index entry that an ingest would write for a tile, except for the heights.
inline TileRecord RecordOf(const Tile& tile) {
  TileRecord record;
  record.tile_id = tile.id;
  record.codebook_id = tile.codebook_id;
  record.num_landmarks = static_cast<int64_t>(tile.num_landmarks());
  record.num_descriptors = static_cast<int64_t>(tile.num_descriptors());
  record.num_keyframes = static_cast<int64_t>(tile.num_keyframes());
  record.min_h_m = 100.0;
  record.max_h_m = 110.0;
  record.landmark_bounds = tile.id.Bounds();
  return record;
}

// Encodes a tile and adds it to the update. The tile's codebook must be in the map.
inline PayloadId AddTile(const Tile& tile, MapUpdate* update) {
  return update->PutTile(RecordOf(tile), EncodeTile(tile));
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_MAP_BUILDER_H_
