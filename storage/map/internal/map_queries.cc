#include "storage/map/internal/map_queries.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "core/angles.h"
#include "core/error.h"
#include "storage/inspection/geo_box.h"
#include "storage/map/internal/accuracy_table.h"
#include "storage/map/internal/map_rows.h"
#include "storage/map/internal/version_queries.h"

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
    CAIRN_KEYFRAME_COLUMNS "WHERE k.session_id = ? AND p.since <= ? ORDER BY k.keyframe_id";
constexpr std::string_view kKeyframesOfTileSql =
    CAIRN_KEYFRAME_COLUMNS "WHERE k.tile_id = ? AND p.since <= ? ORDER BY k.keyframe_id";
constexpr std::string_view kFindKeyframeSql = CAIRN_KEYFRAME_COLUMNS "WHERE k.keyframe_id = ?";

#undef CAIRN_KEYFRAME_COLUMNS

// The columns that ReadTile expects, in order. A damaged map may lack a payload.
#define CAIRN_TILE_COLUMNS                                                              \
  "SELECT c.tile_id, t.payload_id, t.codebook_id, c.num_landmarks, c.num_descriptors, " \
  "c.num_keyframes, c.num_bytes, c.min_h_m, c.max_h_m, t.landmarks_south_deg, "         \
  "t.landmarks_west_deg, t.landmarks_north_deg, t.landmarks_east_deg, coalesce(p.digest, '') "
#define CAIRN_SELECT_TILES                                             \
  CAIRN_TILE_COLUMNS                                                   \
  "FROM coverage AS c JOIN cairn_tiles AS t ON t.tile_id = c.tile_id " \
  "LEFT JOIN cairn_payloads AS p ON p.payload_id = t.payload_id "

constexpr std::string_view kFindTilesSql = CAIRN_TILE_COLUMNS
    "FROM rtree_coverage_geom AS r "
    "JOIN coverage AS c ON c.tile_id = r.id "
    "JOIN cairn_tiles AS t ON t.tile_id = r.id "
    "LEFT JOIN cairn_payloads AS p ON p.payload_id = t.payload_id "
    "WHERE r.maxx >= ? AND r.minx <= ? AND r.maxy >= ? AND r.miny <= ? AND t.since <= ?";
// The same through PostGIS's index.
constexpr std::string_view kFindTilesPostgresSql =
    CAIRN_SELECT_TILES "WHERE c.geom && ST_MakeEnvelope(?1, ?3, ?2, ?4, 4326) AND t.since <= ?5";

constexpr std::string_view kFindTileSql = CAIRN_SELECT_TILES "WHERE c.tile_id = ? AND t.since <= ?";

constexpr std::string_view kAllTilesSql =
    CAIRN_SELECT_TILES "WHERE t.since <= ? ORDER BY c.tile_id LIMIT ?";

constexpr std::string_view kTilesWithIdsSql =
    CAIRN_SELECT_TILES "WHERE c.tile_id IN (SELECT value FROM json_each(?)) AND t.since <= ?";
// The same with the latest version, because each statement is a round trip. If there are no tiles,
// one row has the version alone.
constexpr int kLatestColumn = 14;
constexpr std::string_view kTilesWithIdsPostgresSql = CAIRN_TILE_COLUMNS
    ", v.latest "
    "FROM (SELECT max(version) AS latest FROM cairn_versions) AS v "
    "LEFT JOIN (coverage AS c JOIN cairn_tiles AS t ON t.tile_id = c.tile_id) "
    "ON c.tile_id = ANY (CAST(? AS bigint[])) AND t.since <= ? "
    "LEFT JOIN cairn_payloads AS p ON p.payload_id = t.payload_id";

#undef CAIRN_SELECT_TILES
#undef CAIRN_TILE_COLUMNS

// The columns that ReadSession expects, in order.
#define CAIRN_SESSION_COLUMNS                                                              \
  "SELECT session_id, name, source, created_at, recorded_at, content_digest, num_images, " \
  "num_landmarks, georef_median_residual_m FROM cairn_sessions "

constexpr std::string_view kSessionsSql =
    CAIRN_SESSION_COLUMNS "WHERE since <= ? ORDER BY session_id";
constexpr std::string_view kFindSessionSql = CAIRN_SESSION_COLUMNS "WHERE name = ? AND since <= ?";

#undef CAIRN_SESSION_COLUMNS

// Returns the tiles, if any, and the version of the rows of kTilesWithIdsPostgresSql.
TilesAndLatest ReadTilesAndLatest(db::Connection* connection, db::Statement* rows) {
  TilesAndLatest found;
  while (rows->Step()) {
    found.latest = MapVersion(rows->Int64(kLatestColumn));
    if (!rows->IsNull(0)) {
      found.tiles.push_back(rows::ReadTile(*connection, *rows));
    }
  }
  return found;
}

// Appends the tiles whose indexed rectangle intersects the given rectangle, in degrees.
void AppendTiles(db::Connection* connection, double west_deg, double east_deg, double south_deg,
                 double north_deg, MapVersion as_of, std::vector<TileRecord>* tiles) {
  db::Statement found = connection->Prepare(
      connection->dialect() == db::Dialect::kSqlite ? kFindTilesSql : kFindTilesPostgresSql);
  found.Bind(west_deg, east_deg, south_deg, north_deg, Value(as_of));
  for (TileRecord& tile : rows::ReadTiles(*connection, &found)) {
    tiles->push_back(std::move(tile));
  }
}

}  // namespace

std::string_view TilesOfSessionSql() { return kTilesOfSessionSql; }
std::string_view KeyframesOfSessionSql() { return kKeyframesOfSessionSql; }
std::string_view KeyframesOfTileSql() { return kKeyframesOfTileSql; }
std::string_view FindTilesSql() { return kFindTilesSql; }
std::string_view FindTileSql() { return kFindTileSql; }
std::string_view TilesWithIdsSql() { return kTilesWithIdsSql; }

MapInfo Info(db::Connection* connection, MapVersion version) {
  MapInfo info;
  static_cast<MapTotals&>(info) = FindVersion(connection, version).totals;
  info.version = version;
  db::Statement row = connection->Prepare("SELECT created_at FROM cairn_map");
  row.Step();
  info.created_at = row.Text(0);
  info.file_bytes = static_cast<int64_t>(connection->BytesOnDisk());
  return info;
}

std::vector<TileRecord> FindTiles(db::Connection* connection, const GeoBox& box, MapVersion as_of) {
  constexpr double kTurnDeg = 360.0;  // Indexed longitudes lie in [-360, 360].
  const double west_deg = box.west_rad * kDegPerRad;
  const double east_deg = box.east_rad * kDegPerRad + (box.CrossesAntimeridian() ? kTurnDeg : 0.0);
  std::vector<TileRecord> tiles;
  for (const double turn_deg : {-kTurnDeg, 0.0, kTurnDeg}) {
    const double from_deg = west_deg + turn_deg, to_deg = east_deg + turn_deg;
    if (to_deg >= -kTurnDeg && from_deg <= kTurnDeg) {
      AppendTiles(connection, from_deg, to_deg, box.south_rad * kDegPerRad,
                  box.north_rad * kDegPerRad, as_of, &tiles);
    }
  }
  // The index rounds boxes outwards to floats, and the searches may return a tile twice.
  std::erase_if(tiles,
                [&box](const TileRecord& tile) { return !BoxesMeet(tile.tile_id.Bounds(), box); });
  SortById(&tiles);
  return tiles;
}

std::vector<TileRecord> AllTiles(db::Connection* connection, int64_t limit, MapVersion as_of) {
  db::Statement found = connection->Prepare(kAllTilesSql);
  found.Bind(Value(as_of), std::max<int64_t>(limit, 0));
  return rows::ReadTiles(*connection, &found);
}

std::string IdList(const db::Connection& connection, const std::vector<int64_t>& ids) {
  const bool is_file = connection.dialect() == db::Dialect::kSqlite;
  return fmt::format("{}{}{}", is_file ? '[' : '{', fmt::join(ids, ","), is_file ? ']' : '}');
}

TilesAndLatest TilesWithIds(db::Connection* connection, const std::vector<int64_t>& ids,
                            MapVersion as_of) {
  const bool is_file = connection->dialect() == db::Dialect::kSqlite;
  db::Statement found = connection->Prepare(is_file ? kTilesWithIdsSql : kTilesWithIdsPostgresSql);
  found.Bind(std::string_view(IdList(*connection, ids)), Value(as_of));
  if (!is_file) {
    return ReadTilesAndLatest(connection, &found);
  }
  std::vector<TileRecord> tiles = rows::ReadTiles(*connection, &found);
  return {std::move(tiles), LatestVersion(connection)};
}

std::vector<int64_t> AllTileIds(db::Connection* connection) {
  std::vector<int64_t> tile_ids;
  db::Statement rows = connection->Prepare("SELECT tile_id FROM coverage ORDER BY tile_id");
  while (rows.Step()) {
    tile_ids.push_back(rows.Int64(0));
  }
  return tile_ids;
}

std::optional<TileRecord> FindTile(db::Connection* connection, TileId tile_id, MapVersion as_of) {
  db::Statement row = connection->Prepare(kFindTileSql);
  if (!row.Bind(static_cast<int64_t>(tile_id.value()), Value(as_of)).Step()) {
    return std::nullopt;
  }
  return rows::ReadTile(*connection, row);
}

LargeVector<uint8_t> LoadPayload(db::Connection* connection, PayloadId payload_id) {
  auto payload = connection->ReadBytes("cairn_payloads", "payload_id", Value(payload_id));
  if (!payload) {
    throw Error(ErrorCode::kMapDamaged,
                connection->name() + ": has no payload " + std::to_string(Value(payload_id)));
  }
  return *std::move(payload);
}

LandmarkId NextLandmarkId(db::Connection* connection) {
  db::Statement row =
      connection->Prepare("SELECT coalesce(max(next_landmark_id), 1) FROM cairn_map");
  row.Step();
  return LandmarkId(static_cast<uint64_t>(row.Int64(0)));
}

CodebookId CurrentCodebookId(db::Connection* connection) {
  db::Statement row = connection->Prepare("SELECT coalesce(max(codebook_id), 0) FROM cairn_map");
  row.Step();
  return CodebookId(row.Int64(0));
}

std::shared_ptr<const Codebook> LoadCodebook(db::Connection* connection, CodebookId codebook_id) {
  const auto bytes = connection->ReadBytes("cairn_codebooks", "codebook_id", Value(codebook_id));
  if (!bytes) {
    throw Error(ErrorCode::kMapDamaged,
                connection->name() + ": has no codebook " + std::to_string(Value(codebook_id)));
  }
  return rows::MakeFromRow(*connection, [&] {
    return std::make_shared<const Codebook>(
        DecodeCodebook(bytes->data(), bytes->size(), codebook_id));
  });
}

std::vector<CodebookId> CodebookIds(db::Connection* connection) {
  std::vector<CodebookId> ids;
  db::Statement rows =
      connection->Prepare("SELECT codebook_id FROM cairn_codebooks ORDER BY codebook_id");
  while (rows.Step()) {
    ids.push_back(CodebookId(rows.Int64(0)));
  }
  return ids;
}

std::string CodebookDigest(db::Connection* connection, CodebookId codebook_id) {
  db::Statement row =
      connection->Prepare("SELECT digest FROM cairn_codebooks WHERE codebook_id = ?");
  if (!row.Bind(Value(codebook_id)).Step()) {
    throw Error(ErrorCode::kMapDamaged,
                connection->name() + ": has no codebook " + std::to_string(Value(codebook_id)));
  }
  return row.Text(0);
}

CodebookId FindCodebook(db::Connection* connection, const std::string& digest) {
  db::Statement row =
      connection->Prepare("SELECT codebook_id FROM cairn_codebooks WHERE digest = ?");
  return row.Bind(digest).Step() ? CodebookId(row.Int64(0)) : CodebookId{};
}

std::vector<SessionRecord> Sessions(db::Connection* connection, MapVersion as_of) {
  std::vector<SessionRecord> sessions;
  db::Statement rows = connection->Prepare(kSessionsSql);
  rows.Bind(Value(as_of));
  while (rows.Step()) {
    sessions.push_back(rows::ReadSession(rows));
  }
  accuracy_table::Attach(connection, &sessions);
  return sessions;
}

std::optional<SessionRecord> FindSession(db::Connection* connection, const std::string& name,
                                         MapVersion as_of) {
  std::vector<SessionRecord> found;
  db::Statement row = connection->Prepare(kFindSessionSql);
  if (row.Bind(name, Value(as_of)).Step()) {
    found.push_back(rows::ReadSession(row));
  }
  accuracy_table::Attach(connection, &found);
  return found.empty() ? std::nullopt : std::optional(std::move(found.front()));
}

std::vector<TileId> TilesOfSession(db::Connection* connection, SessionId session_id) {
  std::vector<TileId> tile_ids;
  db::Statement rows = connection->Prepare(kTilesOfSessionSql);
  rows.Bind(Value(session_id));
  while (rows.Step()) {
    tile_ids.push_back(rows::ReadTileId(*connection, rows.Int64(0)));
  }
  return tile_ids;
}

std::vector<KeyframeId> KeyframeIdsOfSession(db::Connection* connection, SessionId session_id) {
  std::vector<KeyframeId> ids;
  db::Statement rows =
      connection->Prepare("SELECT keyframe_id FROM keyframes WHERE session_id = ?");
  rows.Bind(Value(session_id));
  while (rows.Step()) {
    ids.push_back(KeyframeId(rows.Int64(0)));
  }
  return ids;
}

std::optional<KeyframeRecord> FindKeyframe(db::Connection* connection, KeyframeId keyframe_id) {
  db::Statement row = connection->Prepare(kFindKeyframeSql);
  if (!row.Bind(Value(keyframe_id)).Step()) {
    return std::nullopt;
  }
  return rows::ReadKeyframe(*connection, row);
}

std::vector<KeyframeRecord> KeyframesOfSession(db::Connection* connection, SessionId session_id,
                                               MapVersion as_of) {
  db::Statement rows = connection->Prepare(kKeyframesOfSessionSql);
  rows.Bind(Value(session_id), Value(as_of));
  return rows::ReadKeyframes(*connection, &rows);
}

std::vector<KeyframeRecord> KeyframesOfTile(db::Connection* connection, TileId tile_id,
                                            MapVersion as_of) {
  db::Statement rows = connection->Prepare(kKeyframesOfTileSql);
  rows.Bind(static_cast<int64_t>(tile_id.value()), Value(as_of));
  return rows::ReadKeyframes(*connection, &rows);
}

}  // namespace cairn::queries
