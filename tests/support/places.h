// A map of places, each a tile with a session of its own, for tests that change maps again and
// again.
#ifndef CAIRN_TESTS_SUPPORT_PLACES_H_
#define CAIRN_TESTS_SUPPORT_PLACES_H_

#include <string>
#include <vector>

#include "core/geodesy.h"
#include "storage/map/describe_tile.h"
#include "storage/map/map_store.h"
#include "storage/map/sql_shell.h"
#include "support/map_builder.h"
#include "support/street_map.h"
#include "support/tile_builder.h"
#ifdef CAIRN_WITH_POSTGRES
#include "storage/database/postgres/server.h"
#endif

namespace cairn::testing {

inline Geodetic PositionOfPlace(int place) {
  return Geodetic::FromDegrees(49.011, 8.416 + 0.0021 * place, 115.0);
}

inline TileId TileOfPlace(int place) { return TileId::Containing(PositionOfPlace(place)); }

inline std::string NameOfPlace(int place, const std::string& prefix = "place ") {
  return prefix + std::to_string(place);
}

// Takes the tile, the session and the keyframes of a place out of the map, if they are there.
inline void RemovePlace(int place, MapUpdate* update, const std::string& prefix = "place ") {
  if (const auto session = update->FindSession(NameOfPlace(place, prefix))) {
    update->RemoveSession(session->id);
    update->RemoveTile(TileOfPlace(place));
  }
}

// Puts new content at a place, as an ingest would.
inline void PutPlace(int place, uint64_t seed, MapUpdate* update, int num_landmarks = 20,
                     const std::string& prefix = "place ") {
  RemovePlace(place, update, prefix);
  if (update->CurrentCodebook() == nullptr) {
    update->AddCodebook(RandomCodebook());
  }
  RandomTileOptions options;
  options.id = TileOfPlace(place);
  options.codebook_id = update->CurrentCodebook()->id;
  options.num_landmarks = num_landmarks;
  options.num_keyframes = 2;
  options.num_landmarks_per_keyframe = num_landmarks;
  options.session_id = Value(update->AddSession(NamedSession(NameOfPlace(place, prefix))));
  options.first_landmark_id = Value(update->ReserveLandmarkIds(num_landmarks));
  options.seed = seed;
  const KeyframeRecord keyframe = KeyframeAt(PositionOfPlace(place), SessionId(options.session_id));
  options.first_keyframe_id = Value(update->AddKeyframe(keyframe));
  update->AddKeyframe(keyframe);
  Tile tile = RandomTile(options);
  for (TileKeyframe& in_tile : tile.keyframes) {
    in_tile.cam_from_tile = keyframe.cam_from_ecef * EcefFromEnu(tile.id.Anchor());
  }
  update->PutTile(DescribeTile(tile), EncodeTile(tile));
}

// The rows of a query, a line each. Of a map on a server, only with CAIRN_WITH_POSTGRES.
inline std::vector<std::string> RowsOf(const std::string& path, const std::string& sql) {
  std::vector<std::string> lines;
#ifdef CAIRN_WITH_POSTGRES
  if (path.starts_with("postgresql:")) {
    const auto connection = postgres::Server(path).Connect(postgres::Use::kRead, {});
    const postgres::Result rows = connection->link().Run(sql);
    for (int row = 0; row < PQntuples(rows.get()); ++row) {
      lines.emplace_back();
      for (int column = 0; column < PQnfields(rows.get()); ++column) {
        lines.back() += (column == 0 ? "" : " | ");
        lines.back() += PQgetvalue(rows.get(), row, column);
      }
    }
    return lines;
  }
#endif
  SqlSink sink;
  sink.on_columns = [](const std::vector<std::string>&) {};
  sink.on_row = [&lines](const std::vector<SqlCell>& row) {
    lines.emplace_back();
    for (const SqlCell& cell : row) {
      lines.back() += (lines.back().empty() ? "" : " | ") + cell.text;
    }
  };
  RunSql(path, sql, SqlOptions(), sink);
  return lines;
}

// All that the latest version holds: tiles by digest, sessions and keyframes by id and content.
inline std::vector<std::string> ContentOf(const std::string& path) {
  std::vector<std::string> content;
  for (const char* sql :
       {"SELECT c.tile, p.digest, c.num_landmarks, c.min_h_m, t.landmarks_west_deg "
        "FROM cairn_tiles AS t JOIN coverage AS c USING (tile_id) "
        "JOIN cairn_payloads AS p USING (payload_id) ORDER BY c.tile",
        "SELECT session_id, name, created_at, recorded_at, num_images FROM cairn_sessions "
        "ORDER BY session_id",
        "SELECT k.keyframe_id, k.session_id, k.tile_id, k.image_name, k.lat_deg, "
        "k.heading_deg, p.qw, p.tx_m, c.params FROM keyframes AS k "
        "JOIN cairn_keyframe_poses AS p USING (keyframe_id) "
        "JOIN cairn_cameras AS c USING (camera_id) ORDER BY k.keyframe_id",
        "SELECT codebook_id FROM cairn_map"}) {
    for (std::string& row : RowsOf(path, sql)) {
      content.push_back(std::move(row));
    }
  }
  return content;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_PLACES_H_
