#include "storage/map/map_queries.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/angles.h"
#include "core/error.h"
#include "core/printable.h"
#include "storage/geometry/geo_box.h"
#include "storage/sqlite/blob.h"
#include "storage/tile/tile_checks.h"

namespace cairn::queries {
namespace {

constexpr std::string_view kCurrentVersionSql =
    "SELECT version FROM cairn_versions ORDER BY version DESC LIMIT 1";

constexpr std::string_view kTilesOfSessionSql =
    "SELECT DISTINCT tile_id FROM keyframes WHERE session_id = ? ORDER BY tile_id";

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

// Calls `make`. If `make` rejects a value that was read from the map, throws Error(kMapDamaged).
template <typename Make>
auto MakeFromRow(const sqlite::Connection& connection, const Make& make) {
  try {
    return make();
  } catch (const Error& error) {
    throw Error(ErrorCode::kMapDamaged, connection.path() + ": " + error.what());
  }
}

TileId ReadTileId(const sqlite::Connection& connection, int64_t value) {
  return MakeFromRow(connection,
                     [value] { return TileId::FromValue(static_cast<uint64_t>(value)); });
}

// Queries search for cameras between these heights.
void RequireHeights(const sqlite::Connection& connection, const TileRecord& tile) {
  constexpr double kMaxHeightM = 1e5;
  if (!(-kMaxHeightM <= tile.min_h_m && tile.min_h_m <= tile.max_h_m &&
        tile.max_h_m <= kMaxHeightM)) {
    throw Error(
        ErrorCode::kMapDamaged,
        fmt::format("{}: tile {}: its cameras have heights of {} to {} m", connection.path(),
                    tile.tile_id.ToString(), tile.min_h_m, tile.max_h_m));
  }
}

TileRecord ReadTile(const sqlite::Connection& connection, const sqlite::Statement& row) {
  TileRecord tile;
  tile.tile_id = ReadTileId(connection, row.Int64(0));
  tile.payload_id = PayloadId(row.Int64(1));
  tile.codebook_id = CodebookId(row.Int64(2));
  tile.num_landmarks = row.Int64(3);
  tile.num_descriptors = row.Int64(4);
  tile.num_keyframes = row.Int64(5);
  tile.num_bytes = row.Int64(6);
  tile.min_h_m = row.Double(7);
  tile.max_h_m = row.Double(8);
  RequireHeights(connection, tile);
  tile.landmark_bounds = {row.Double(9) / kDegPerRad, row.Double(10) / kDegPerRad,
                          row.Double(11) / kDegPerRad, row.Double(12) / kDegPerRad};
  return tile;
}

SessionRecord ReadSession(const sqlite::Statement& row) {
  SessionRecord session;
  session.id = SessionId(row.Int64(0));
  session.name = row.Text(1);
  session.source = row.Text(2);
  session.created_at = row.Text(3);
  session.recorded_at = row.Text(4);
  session.content_digest = row.Text(5);
  session.num_images = row.Int64(6);
  session.num_landmarks = row.Int64(7);
  session.georef_median_residual_m = row.Double(8);
  return session;
}

// Parses "[1.5,2,3]". Throws Error if the text is anything else.
std::vector<double> ParseNumbers(std::string_view text) {
  std::vector<double> numbers;
  const auto refuse = [text] {
    return Error(ErrorCode::kMapDamaged,
                 "camera parameters '" + Excerpt(text) + "' are not a list of numbers");
  };
  if (text.size() < 2 || text.front() != '[' || text.back() != ']') {
    throw refuse();
  }
  const char* next = text.data() + 1;
  const char* const end = text.data() + text.size() - 1;
  while (true) {
    double number = 0.0;
    const auto [after, error] = std::from_chars(next, end, number);
    if (error != std::errc()) {
      throw refuse();
    }
    numbers.push_back(number);
    if (after == end) {
      return numbers;
    }
    if (*after != ',') {
      throw refuse();
    }
    next = after + 1;
  }
}

KeyframeRecord ReadKeyframe(const sqlite::Connection& connection, const sqlite::Statement& row) {
  KeyframeRecord keyframe;
  keyframe.id = KeyframeId(row.Int64(0));
  keyframe.session_id = SessionId(row.Int64(1));
  keyframe.tile_id = ReadTileId(connection, row.Int64(2));
  keyframe.image_name = row.Text(3);
  keyframe.camera = MakeFromRow(connection, [&row] {
    return Camera(CameraModelFromName(row.Text(4)), static_cast<int>(row.Int64(5)),
                  static_cast<int>(row.Int64(6)), ParseNumbers(row.Text(7)));
  });
  // Keeps the stored quaternion; the constructor would normalise it again.
  keyframe.cam_from_ecef.rotation =
      Eigen::Quaterniond(row.Double(8), row.Double(9), row.Double(10), row.Double(11));
  keyframe.cam_from_ecef.translation = {row.Double(12), row.Double(13), row.Double(14)};
  if (!IsPose(keyframe.cam_from_ecef)) {
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("{}: keyframe {}: its pose is not a rigid transform", connection.path(),
                            Value(keyframe.id)));
  }
  return keyframe;
}

// The rows of a statement that selects the columns of ReadKeyframe, its parameters bound.
std::vector<KeyframeRecord> ReadKeyframes(const sqlite::Connection& connection,
                                          sqlite::Statement* rows) {
  std::vector<KeyframeRecord> keyframes;
  while (rows->Step()) {
    keyframes.push_back(ReadKeyframe(connection, *rows));
  }
  return keyframes;
}

// Appends the tiles whose indexed rectangle intersects the given rectangle, in degrees.
void AppendTiles(sqlite::Connection* connection, double west_deg, double east_deg, double south_deg,
                 double north_deg, std::vector<TileRecord>* tiles) {
  sqlite::Statement rows = connection->Prepare(kFindTilesSql);
  rows.Bind(west_deg, east_deg, south_deg, north_deg);
  while (rows.Step()) {
    tiles->push_back(ReadTile(*connection, rows));
  }
}

}  // namespace

std::string_view CurrentVersionSql() { return kCurrentVersionSql; }
std::string_view TilesOfSessionSql() { return kTilesOfSessionSql; }
std::string_view KeyframesOfSessionSql() { return kKeyframesOfSessionSql; }
std::string_view KeyframesOfTileSql() { return kKeyframesOfTileSql; }
std::string_view FindTilesSql() { return kFindTilesSql; }
std::string_view FindTileSql() { return kFindTileSql; }

MapVersion CurrentVersion(sqlite::Connection* connection) {
  sqlite::Statement row = connection->Prepare(kCurrentVersionSql);
  if (!row.Step()) {
    throw Error(ErrorCode::kMapDamaged, connection->path() + ": the table cairn_versions is empty");
  }
  return MapVersion(row.Int64(0));
}

MapInfo Info(sqlite::Connection* connection) {
  MapInfo info;
  info.version = CurrentVersion(connection);
  // Uses sum(1) because SQLite does not check for interruption while it counts rows for count(*).
  sqlite::Statement row = connection->Prepare(
      "SELECT (SELECT created_at FROM cairn_map), "
      "(SELECT coalesce(sum(1), 0) FROM cairn_sessions), "
      "(SELECT coalesce(sum(1), 0) FROM keyframes), count(*), coalesce(sum(num_landmarks), 0), "
      "coalesce(sum(num_descriptors), 0), coalesce(sum(num_bytes), 0) FROM coverage");
  row.Step();
  info.created_at = row.Text(0);
  info.num_sessions = row.Int64(1);
  info.num_keyframes = row.Int64(2);
  info.num_tiles = row.Int64(3);
  info.num_landmarks = row.Int64(4);
  info.num_descriptors = row.Int64(5);
  info.payload_bytes = row.Int64(6);
  std::error_code ignored;
  info.file_bytes = static_cast<int64_t>(std::filesystem::file_size(connection->path(), ignored));

  std::vector<GeoBox> boxes;
  for (const int64_t tile_id : AllTileIds(connection)) {
    boxes.push_back(ReadTileId(*connection, tile_id).Bounds());
  }
  info.bounds = BoxAroundAll(std::move(boxes));
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
    tiles.push_back(ReadTile(*connection, rows));
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
  return ReadTile(*connection, row);
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
      connection->Prepare("SELECT coalesce(max(codebook_id), 0) FROM cairn_codebooks");
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
  return MakeFromRow(*connection, [&] {
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

std::vector<SessionRecord> Sessions(sqlite::Connection* connection) {
  std::vector<SessionRecord> sessions;
  sqlite::Statement rows = connection->Prepare(kSessionsSql);
  while (rows.Step()) {
    sessions.push_back(ReadSession(rows));
  }
  return sessions;
}

std::optional<SessionRecord> FindSession(sqlite::Connection* connection, const std::string& name) {
  sqlite::Statement row = connection->Prepare(kFindSessionSql);
  if (!row.Bind(name).Step()) {
    return std::nullopt;
  }
  return ReadSession(row);
}

std::vector<TileId> TilesOfSession(sqlite::Connection* connection, SessionId session_id) {
  std::vector<TileId> tile_ids;
  sqlite::Statement rows = connection->Prepare(kTilesOfSessionSql);
  rows.Bind(Value(session_id));
  while (rows.Step()) {
    tile_ids.push_back(ReadTileId(*connection, rows.Int64(0)));
  }
  return tile_ids;
}

std::optional<KeyframeRecord> FindKeyframe(sqlite::Connection* connection, KeyframeId keyframe_id) {
  sqlite::Statement row = connection->Prepare(kFindKeyframeSql);
  if (!row.Bind(Value(keyframe_id)).Step()) {
    return std::nullopt;
  }
  return ReadKeyframe(*connection, row);
}

std::vector<KeyframeRecord> KeyframesOfSession(sqlite::Connection* connection,
                                               SessionId session_id) {
  sqlite::Statement rows = connection->Prepare(kKeyframesOfSessionSql);
  rows.Bind(Value(session_id));
  return ReadKeyframes(*connection, &rows);
}

std::vector<KeyframeRecord> KeyframesOfTile(sqlite::Connection* connection, TileId tile_id) {
  sqlite::Statement rows = connection->Prepare(kKeyframesOfTileSql);
  rows.Bind(static_cast<int64_t>(tile_id.value()));
  return ReadKeyframes(*connection, &rows);
}

}  // namespace cairn::queries
