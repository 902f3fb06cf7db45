#include "storage/map/map_queries.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/angles.h"
#include "core/error.h"
#include "storage/geometry/geo_box.h"
#include "storage/map/map_rows.h"
#include "storage/map/version_queries.h"
#include "storage/sqlite/blob.h"

namespace cairn::queries {
namespace {

constexpr std::string_view kTilesOfSessionSql =
    "SELECT tile_id FROM cairn_session_tiles WHERE session_id = ? ORDER BY tile_id";

// The columns that ReadKeyframe expects, in order.
#define CAIRN_KEYFRAME_COLUMNS                                                         \
  "SELECT k.keyframe_id, k.session_id, k.tile_id, k.image_name, c.model, c.width_px, " \
  "c.height_px, c.params, p.qw, p.qx, p.qy, p.qz, p.tx_m, p.ty_m, p.tz_m "             \
  "FROM keyframes AS k "                                                               \
  "JOIN cairn_keyframe_poses AS p ON p.keyframe_id = k.keyframe_id "                   \
  "JOIN cairn_cameras AS c ON c.camera_id = p.camera_id "

constexpr std::string_view kKeyframesOfSessionSql =
    CAIRN_KEYFRAME_COLUMNS "WHERE k.session_id = ? ORDER BY k.keyframe_id";
constexpr std::string_view kKeyframesOfTileSql =
    CAIRN_KEYFRAME_COLUMNS "WHERE k.tile_id = ? ORDER BY k.keyframe_id";
constexpr std::string_view kFindKeyframeSql = CAIRN_KEYFRAME_COLUMNS "WHERE k.keyframe_id = ?";

#undef CAIRN_KEYFRAME_COLUMNS

// The columns that ReadTile expects, in order.
#define CAIRN_TILE_COLUMNS                                                       \
  "c.tile_id, t.payload_id, t.codebook_id, c.num_landmarks, c.num_descriptors, " \
  "c.num_keyframes, c.num_bytes, c.min_h_m, c.max_h_m, t.landmarks_south_deg, "  \
  "t.landmarks_west_deg, t.landmarks_north_deg, t.landmarks_east_deg "

constexpr std::string_view kFindTilesSql =
    "SELECT " CAIRN_TILE_COLUMNS
    "FROM rtree_coverage_geom AS r "
    "JOIN coverage AS c ON c.tile_id = r.id "
    "JOIN cairn_tiles AS t ON t.tile_id = r.id "
    "WHERE r.maxx >= ? AND r.minx <= ? AND r.maxy >= ? AND r.miny <= ?";

constexpr std::string_view kFindTileSql =
    "SELECT " CAIRN_TILE_COLUMNS
    "FROM coverage AS c JOIN cairn_tiles AS t ON t.tile_id = c.tile_id WHERE c.tile_id = ?";

constexpr std::string_view kAllTilesSql =
    "SELECT " CAIRN_TILE_COLUMNS
    "FROM coverage AS c JOIN cairn_tiles AS t ON t.tile_id = c.tile_id ORDER BY c.tile_id LIMIT ?";

#undef CAIRN_TILE_COLUMNS

// The columns that ReadSession expects, in order.
#define CAIRN_SESSION_COLUMNS                                                              \
  "SELECT session_id, name, source, created_at, recorded_at, content_digest, num_images, " \
  "num_landmarks, georef_median_residual_m FROM cairn_sessions "

constexpr std::string_view kSessionsSql = CAIRN_SESSION_COLUMNS "ORDER BY session_id";
constexpr std::string_view kFindSessionSql = CAIRN_SESSION_COLUMNS "WHERE name = ?";

#undef CAIRN_SESSION_COLUMNS

// Appends the tiles whose indexed rectangle intersects the given rectangle, in degrees.
void AppendTiles(sqlite::Connection* connection, double west_deg, double east_deg, double south_deg,
                 double north_deg, std::vector<TileRecord>* tiles) {
  sqlite::Statement found = connection->Prepare(kFindTilesSql);
  found.Bind(west_deg, east_deg, south_deg, north_deg);
  while (found.Step()) {
    tiles->push_back(rows::ReadTile(*connection, found));
  }
}

}  // namespace

std::string_view TilesOfSessionSql() { return kTilesOfSessionSql; }
std::string_view KeyframesOfSessionSql() { return kKeyframesOfSessionSql; }
std::string_view KeyframesOfTileSql() { return kKeyframesOfTileSql; }
std::string_view FindTilesSql() { return kFindTilesSql; }
std::string_view FindTileSql() { return kFindTileSql; }

MapInfo Info(sqlite::Connection* connection) {
  const VersionRecord latest = LatestVersion(connection);
  MapInfo info;
  static_cast<MapTotals&>(info) = latest.totals;
  info.version = latest.version;
  sqlite::Statement row = connection->Prepare("SELECT created_at FROM cairn_map");
  row.Step();
  info.created_at = row.Text(0);
  std::error_code ignored;
  info.file_bytes = static_cast<int64_t>(std::filesystem::file_size(connection->path(), ignored));
  return info;
}

std::vector<TileRecord> FindTiles(sqlite::Connection* connection, const GeoBox& box) {
  constexpr double kTurnDeg = 360.0;  // Indexed longitudes lie in [-360, 360].
  const double west_deg = box.west_rad * kDegPerRad;
  const double east_deg = box.east_rad * kDegPerRad + (box.CrossesAntimeridian() ? kTurnDeg : 0.0);
  std::vector<TileRecord> tiles;
  for (const double turn_deg : {-kTurnDeg, 0.0, kTurnDeg}) {
    AppendTiles(connection, west_deg + turn_deg, east_deg + turn_deg, box.south_rad * kDegPerRad,
                box.north_rad * kDegPerRad, &tiles);
  }
  // The index rounds boxes outwards to floats, and the searches may return a tile twice.
  std::erase_if(tiles,
                [&box](const TileRecord& tile) { return !BoxesMeet(tile.tile_id.Bounds(), box); });
  const auto by_id = [](const TileRecord& a, const TileRecord& b) { return a.tile_id < b.tile_id; };
  const auto same_id = [](const TileRecord& a, const TileRecord& b) {
    return a.tile_id == b.tile_id;
  };
  std::sort(tiles.begin(), tiles.end(), by_id);
  tiles.erase(std::unique(tiles.begin(), tiles.end(), same_id), tiles.end());
  return tiles;
}

std::vector<TileRecord> AllTiles(sqlite::Connection* connection, int64_t limit) {
  std::vector<TileRecord> tiles;
  sqlite::Statement rows = connection->Prepare(kAllTilesSql);
  rows.Bind(std::max<int64_t>(limit, 0));
  while (rows.Step()) {
    tiles.push_back(rows::ReadTile(*connection, rows));
  }
  return tiles;
}

std::vector<int64_t> AllTileIds(sqlite::Connection* connection) {
  std::vector<int64_t> tile_ids;
  sqlite::Statement rows = connection->Prepare("SELECT tile_id FROM coverage ORDER BY tile_id");
  while (rows.Step()) {
    tile_ids.push_back(rows.Int64(0));
  }
  return tile_ids;
}

std::optional<TileRecord> FindTile(sqlite::Connection* connection, TileId tile_id) {
  sqlite::Statement row = connection->Prepare(kFindTileSql);
  if (!row.Bind(static_cast<int64_t>(tile_id.value())).Step()) {
    return std::nullopt;
  }
  return rows::ReadTile(*connection, row);
}

LargeVector<uint8_t> LoadPayload(sqlite::Connection* connection, PayloadId payload_id) {
  auto payload = sqlite::ReadBlob(connection, "cairn_payloads", "bytes", Value(payload_id));
  if (!payload) {
    throw Error(ErrorCode::kMapDamaged,
                connection->path() + ": has no payload " + std::to_string(Value(payload_id)));
  }
  return *std::move(payload);
}

CodebookId CurrentCodebookId(sqlite::Connection* connection) {
  sqlite::Statement row =
      connection->Prepare("SELECT coalesce(max(codebook_id), 0) FROM cairn_map");
  row.Step();
  return CodebookId(row.Int64(0));
}

std::shared_ptr<const Codebook> LoadCodebook(sqlite::Connection* connection,
                                             CodebookId codebook_id) {
  const auto bytes = sqlite::ReadBlob(connection, "cairn_codebooks", "bytes", Value(codebook_id));
  if (!bytes) {
    throw Error(ErrorCode::kMapDamaged,
                connection->path() + ": has no codebook " + std::to_string(Value(codebook_id)));
  }
  return rows::MakeFromRow(*connection, [&] {
    return std::make_shared<const Codebook>(
        DecodeCodebook(bytes->data(), bytes->size(), codebook_id));
  });
}

std::vector<CodebookId> CodebookIds(sqlite::Connection* connection) {
  std::vector<CodebookId> ids;
  sqlite::Statement rows =
      connection->Prepare("SELECT codebook_id FROM cairn_codebooks ORDER BY codebook_id");
  while (rows.Step()) {
    ids.push_back(CodebookId(rows.Int64(0)));
  }
  return ids;
}

std::string CodebookDigest(sqlite::Connection* connection, CodebookId codebook_id) {
  sqlite::Statement row =
      connection->Prepare("SELECT digest FROM cairn_codebooks WHERE codebook_id = ?");
  if (!row.Bind(Value(codebook_id)).Step()) {
    throw Error(ErrorCode::kMapDamaged,
                connection->path() + ": has no codebook " + std::to_string(Value(codebook_id)));
  }
  return row.Text(0);
}

std::vector<SessionRecord> Sessions(sqlite::Connection* connection) {
  std::vector<SessionRecord> sessions;
  sqlite::Statement rows = connection->Prepare(kSessionsSql);
  while (rows.Step()) {
    sessions.push_back(rows::ReadSession(rows));
  }
  return sessions;
}

std::optional<SessionRecord> FindSession(sqlite::Connection* connection, const std::string& name) {
  sqlite::Statement row = connection->Prepare(kFindSessionSql);
  if (!row.Bind(name).Step()) {
    return std::nullopt;
  }
  return rows::ReadSession(row);
}

std::vector<TileId> TilesOfSession(sqlite::Connection* connection, SessionId session_id) {
  std::vector<TileId> tile_ids;
  sqlite::Statement rows = connection->Prepare(kTilesOfSessionSql);
  rows.Bind(Value(session_id));
  while (rows.Step()) {
    tile_ids.push_back(rows::ReadTileId(*connection, rows.Int64(0)));
  }
  return tile_ids;
}

std::vector<KeyframeId> KeyframeIdsOfSession(sqlite::Connection* connection, SessionId session_id) {
  std::vector<KeyframeId> ids;
  sqlite::Statement rows =
      connection->Prepare("SELECT keyframe_id FROM keyframes WHERE session_id = ?");
  rows.Bind(Value(session_id));
  while (rows.Step()) {
    ids.push_back(KeyframeId(rows.Int64(0)));
  }
  return ids;
}

std::optional<KeyframeRecord> FindKeyframe(sqlite::Connection* connection, KeyframeId keyframe_id) {
  sqlite::Statement row = connection->Prepare(kFindKeyframeSql);
  if (!row.Bind(Value(keyframe_id)).Step()) {
    return std::nullopt;
  }
  return rows::ReadKeyframe(*connection, row);
}

std::vector<KeyframeRecord> KeyframesOfSession(sqlite::Connection* connection,
                                               SessionId session_id) {
  sqlite::Statement rows = connection->Prepare(kKeyframesOfSessionSql);
  rows.Bind(Value(session_id));
  return rows::ReadKeyframes(*connection, &rows);
}

std::vector<KeyframeRecord> KeyframesOfTile(sqlite::Connection* connection, TileId tile_id) {
  sqlite::Statement rows = connection->Prepare(kKeyframesOfTileSql);
  rows.Bind(static_cast<int64_t>(tile_id.value()));
  return rows::ReadKeyframes(*connection, &rows);
}

}  // namespace cairn::queries
