#include "storage/map/internal/version_queries.h"

#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "core/angles.h"
#include "core/error.h"
#include "storage/inspection/geo_box.h"
#include "storage/map/internal/accuracy_table.h"
#include "storage/map/internal/map_queries.h"
#include "storage/map/internal/map_rows.h"
#include "storage/map/utc_time.h"

namespace cairn::queries {
namespace {

constexpr std::string_view kLatestVersionSql =
    "SELECT version FROM cairn_versions ORDER BY version DESC LIMIT 1";

// The columns of ReadVersion, in order.
constexpr std::string_view kLatestVersionsSql =
    "SELECT version, created_at, author, kind, session, summary, num_sessions, num_keyframes, "
    "num_tiles, num_landmarks, num_descriptors, payload_bytes, south_deg, west_deg, north_deg, "
    "east_deg FROM cairn_versions WHERE version <= ? ORDER BY version DESC LIMIT ?";

// The parameter is the older of two versions.
constexpr std::string_view kChangedTilesSql =
    "SELECT tile_id FROM cairn_tiles WHERE since > ?1 UNION "
    "SELECT tile_id FROM cairn_past_tiles WHERE until > ?1";

// The columns of ReadTile, then since and until.
#define CAIRN_PAST_TILE_COLUMNS                                                         \
  "SELECT t.tile_id, t.payload_id, t.codebook_id, t.num_landmarks, t.num_descriptors, " \
  "t.num_keyframes, t.num_bytes, t.min_h_m, t.max_h_m, t.landmarks_south_deg, "         \
  "t.landmarks_west_deg, t.landmarks_north_deg, t.landmarks_east_deg, "                 \
  "coalesce(p.digest, ''), t.since, t.until FROM cairn_past_tiles AS t "                \
  "LEFT JOIN cairn_payloads AS p ON p.payload_id = t.payload_id "

constexpr std::string_view kPastTilesSql =
    CAIRN_PAST_TILE_COLUMNS "WHERE t.since <= ?1 AND t.until > ?1 ORDER BY t.tile_id";
constexpr std::string_view kPastTilesWithIdsSql = CAIRN_PAST_TILE_COLUMNS
    "WHERE t.tile_id IN (SELECT value FROM json_each(?2)) AND t.since <= ?1 AND t.until > ?1 "
    "ORDER BY t.tile_id";
constexpr std::string_view kPastTilesWithIdsPostgresSql = CAIRN_PAST_TILE_COLUMNS
    "WHERE t.tile_id = ANY (CAST(?2 AS bigint[])) AND t.since <= ?1 AND t.until > ?1 "
    "ORDER BY t.tile_id";
// The plus keeps the index of `until` out, so that a page reads only its own tiles.
constexpr std::string_view kPastTilesOfPageSql = CAIRN_PAST_TILE_COLUMNS
    "WHERE t.tile_id > ?2 AND t.tile_id <= ?3 AND t.since <= ?1 AND +t.until > ?1 "
    "ORDER BY t.tile_id";
constexpr std::string_view kAllPastTilesSql = CAIRN_PAST_TILE_COLUMNS "ORDER BY t.tile_id, t.since";

#undef CAIRN_PAST_TILE_COLUMNS

// The columns of ReadKeyframe.
#define CAIRN_PAST_KEYFRAME_COLUMNS                                                    \
  "SELECT p.keyframe_id, p.session_id, p.tile_id, p.image_name, c.model, c.width_px, " \
  "c.height_px, c.params, p.qw, p.qx, p.qy, p.qz, p.tx_m, p.ty_m, p.tz_m "             \
  "FROM cairn_past_keyframes AS p JOIN cairn_cameras AS c ON c.camera_id = p.camera_id "

constexpr std::string_view kPastKeyframesSql =
    CAIRN_PAST_KEYFRAME_COLUMNS "WHERE p.since <= ?1 AND p.until > ?1 ORDER BY p.keyframe_id";
constexpr std::string_view kPastKeyframesOfTileSql = CAIRN_PAST_KEYFRAME_COLUMNS
    "WHERE p.tile_id = ?2 AND p.since <= ?1 AND p.until > ?1 ORDER BY p.keyframe_id";
constexpr std::string_view kPastKeyframesOfSessionSql = CAIRN_PAST_KEYFRAME_COLUMNS
    "WHERE p.session_id = ?2 AND p.since <= ?1 AND p.until > ?1 ORDER BY p.keyframe_id";
constexpr std::string_view kPastKeyframeSql = CAIRN_PAST_KEYFRAME_COLUMNS
    "WHERE p.keyframe_id = ?1 AND p.until > ?2 AND p.since = "
    "(SELECT max(since) FROM cairn_past_keyframes WHERE keyframe_id = ?1 AND since <= ?2)";

#undef CAIRN_PAST_KEYFRAME_COLUMNS

// Columns 12 to 15 of a version.
std::optional<GeoBox> ReadBounds(const db::Statement& row) {
  if (row.IsNull(12)) {
    return std::nullopt;
  }
  return GeoBox{row.Double(12) / kDegPerRad, row.Double(13) / kDegPerRad,
                row.Double(14) / kDegPerRad, row.Double(15) / kDegPerRad};
}

VersionRecord ReadVersion(const db::Statement& row) {
  VersionRecord version;
  version.version = MapVersion(row.Int64(0));
  version.created_at = row.Text(1);
  version.author = row.Text(2);
  version.kind = row.Text(3);
  version.session = row.Text(4);
  version.summary = row.Text(5);
  version.totals.num_sessions = row.Int64(6);
  version.totals.num_keyframes = row.Int64(7);
  version.totals.num_tiles = row.Int64(8);
  version.totals.num_landmarks = row.Int64(9);
  version.totals.num_descriptors = row.Int64(10);
  version.totals.payload_bytes = row.Int64(11);
  version.totals.bounds = ReadBounds(row);
  return version;
}

// Returns the state of a tile in a version.
std::optional<TileState> StateOf(db::Connection* connection, TileId tile_id, MapVersion version) {
  const auto id = static_cast<int64_t>(tile_id.value());
  db::Statement row = connection->Prepare(
      "SELECT s.payload_id, p.digest, s.num_landmarks, s.num_bytes FROM ("
      "SELECT t.payload_id, c.num_landmarks, c.num_bytes FROM cairn_tiles AS t "
      "JOIN coverage AS c ON c.tile_id = t.tile_id WHERE t.tile_id = ?1 AND t.since <= ?2 "
      "UNION ALL SELECT payload_id, num_landmarks, num_bytes FROM cairn_past_tiles "
      "WHERE tile_id = ?1 AND until > ?2 AND since = "
      "(SELECT max(since) FROM cairn_past_tiles WHERE tile_id = ?1 AND since <= ?2)) AS s "
      "JOIN cairn_payloads AS p ON p.payload_id = s.payload_id");
  if (!row.Bind(id, Value(version)).Step()) {
    return std::nullopt;
  }
  return TileState{PayloadId(row.Int64(0)), row.Text(1), row.Int64(2), row.Int64(3)};
}

// Returns text such as "versions 4 to 9".
std::string NameVersions(db::Connection* connection) {
  db::Statement row = connection->Prepare("SELECT min(version), max(version) FROM cairn_versions");
  row.Step();
  const int64_t oldest = row.Int64(0), newest = row.Int64(1);
  return oldest == newest ? fmt::format("version {} only", oldest)
                          : fmt::format("versions {} to {}", oldest, newest);
}

std::string LoginName() {
  passwd entry{};
  passwd* found = nullptr;
  std::vector<char> buffer(1 << 14);
  const uid_t uid = geteuid();
  if (getpwuid_r(uid, &entry, buffer.data(), buffer.size(), &found) == 0 && found != nullptr) {
    return found->pw_name;
  }
  return fmt::format("user {}", uid);
}

}  // namespace

std::string_view LatestVersionSql() { return kLatestVersionSql; }
std::string_view LatestVersionsSql() { return kLatestVersionsSql; }
std::string_view ChangedTilesSql() { return kChangedTilesSql; }
std::string_view PastTilesWithIdsSql() { return kPastTilesWithIdsSql; }
std::string_view PastTilesOfPageSql() { return kPastTilesOfPageSql; }

MapVersion LatestVersion(db::Connection* connection) {
  db::Statement row = connection->Prepare(kLatestVersionSql);
  if (!row.Step()) {
    throw Error(ErrorCode::kMapDamaged, connection->name() + ": the table cairn_versions is empty");
  }
  return MapVersion(row.Int64(0));
}

std::vector<VersionRecord> Versions(db::Connection* connection, int64_t limit, MapVersion as_of) {
  std::vector<VersionRecord> versions;
  db::Statement row = connection->Prepare(kLatestVersionsSql);
  row.Bind(Value(as_of), std::max<int64_t>(limit, 0));
  while (row.Step()) {
    versions.push_back(ReadVersion(row));
  }
  return versions;
}

VersionRecord LatestRecord(db::Connection* connection) {
  std::vector<VersionRecord> versions = Versions(connection, 1, kNewest);
  if (versions.empty()) {
    throw Error(ErrorCode::kMapDamaged, connection->name() + ": the table cairn_versions is empty");
  }
  return std::move(versions.front());
}

VersionRecord FindVersion(db::Connection* connection, MapVersion version) {
  std::vector<VersionRecord> versions = Versions(connection, 1, version);
  if (versions.empty() || versions.front().version != version) {
    RequireVersion(connection, version);
    throw Error(ErrorCode::kMapDamaged,
                connection->name() + ": the table cairn_versions is unsound");
  }
  return std::move(versions.front());
}

CodebookId CodebookOfVersion(db::Connection* connection, MapVersion version) {
  db::Statement row = connection->Prepare(
      "SELECT coalesce(max(codebook_id), 0) FROM cairn_versions WHERE version = ?");
  row.Bind(Value(version)).Step();
  return CodebookId(row.Int64(0));
}

bool HasVersion(db::Connection* connection, MapVersion version) {
  db::Statement row = connection->Prepare("SELECT 1 FROM cairn_versions WHERE version = ?");
  return row.Bind(Value(version)).Step();
}

void RequireVersion(db::Connection* connection, MapVersion version) {
  if (!HasVersion(connection, version)) {
    throw Error(ErrorCode::kNotFound,
                fmt::format("{}: has no version {}; it has {}", connection->name(), Value(version),
                            NameVersions(connection)));
  }
}

std::vector<TileChange> Diff(db::Connection* connection, MapVersion from, MapVersion to) {
  RequireVersion(connection, from);
  RequireVersion(connection, to);
  std::set<TileId> tile_ids;
  db::Statement row = connection->Prepare(kChangedTilesSql);
  row.Bind(std::min(Value(from), Value(to)));
  while (row.Step()) {
    tile_ids.insert(rows::ReadTileId(*connection, row.Int64(0)));
  }
  std::vector<TileChange> changes;
  for (const TileId tile_id : tile_ids) {
    TileChange change{tile_id, {}, {}};
    change.before = StateOf(connection, change.tile_id, from);
    change.after = StateOf(connection, change.tile_id, to);
    const PayloadId before = change.before ? change.before->payload_id : PayloadId{};
    const PayloadId after = change.after ? change.after->payload_id : PayloadId{};
    if (before != after) {
      changes.push_back(std::move(change));
    }
  }
  return changes;
}

std::vector<TileRecord> PastTiles(db::Connection* connection, MapVersion version) {
  db::Statement found = connection->Prepare(kPastTilesSql);
  found.Bind(Value(version));
  return rows::ReadTiles(*connection, &found);
}

std::vector<TileRecord> PastTilesWithIds(db::Connection* connection, MapVersion version,
                                         const std::vector<int64_t>& ids) {
  const bool is_file = connection->dialect() == db::Dialect::kSqlite;
  db::Statement found =
      connection->Prepare(is_file ? kPastTilesWithIdsSql : kPastTilesWithIdsPostgresSql);
  found.Bind(Value(version), std::string_view(IdList(*connection, ids)));
  return rows::ReadTiles(*connection, &found);
}

std::vector<TileRecord> PastTilesOfPage(db::Connection* connection, MapVersion version,
                                        int64_t after, int64_t last) {
  db::Statement found = connection->Prepare(kPastTilesOfPageSql);
  found.Bind(Value(version), after, last);
  return rows::ReadTiles(*connection, &found);
}

std::vector<SessionRecord> PastSessions(db::Connection* connection, MapVersion version) {
  std::vector<SessionRecord> sessions;
  db::Statement row = connection->Prepare(
      "SELECT session_id, name, source, created_at, recorded_at, content_digest, num_images, "
      "num_landmarks, georef_median_residual_m FROM cairn_past_sessions "
      "WHERE since <= ?1 AND until > ?1 ORDER BY session_id");
  row.Bind(Value(version));
  while (row.Step()) {
    sessions.push_back(rows::ReadSession(row));
  }
  accuracy_table::Attach(connection, &sessions);
  return sessions;
}

std::vector<KeyframeRecord> PastKeyframes(db::Connection* connection, MapVersion version) {
  db::Statement row = connection->Prepare(kPastKeyframesSql);
  row.Bind(Value(version));
  return rows::ReadKeyframes(*connection, &row);
}

std::vector<KeyframeRecord> PastKeyframesOfTile(db::Connection* connection, MapVersion version,
                                                TileId tile_id) {
  db::Statement row = connection->Prepare(kPastKeyframesOfTileSql);
  row.Bind(Value(version), static_cast<int64_t>(tile_id.value()));
  return rows::ReadKeyframes(*connection, &row);
}

std::vector<KeyframeRecord> PastKeyframesOfSession(db::Connection* connection, MapVersion version,
                                                   SessionId session_id) {
  db::Statement row = connection->Prepare(kPastKeyframesOfSessionSql);
  row.Bind(Value(version), Value(session_id));
  return rows::ReadKeyframes(*connection, &row);
}

void SortById(std::vector<TileRecord>* tiles) {
  const auto by_id = [](const TileRecord& a, const TileRecord& b) { return a.tile_id < b.tile_id; };
  const auto same_id = [](const TileRecord& a, const TileRecord& b) {
    return a.tile_id == b.tile_id;
  };
  std::sort(tiles->begin(), tiles->end(), by_id);
  tiles->erase(std::unique(tiles->begin(), tiles->end(), same_id), tiles->end());
}

std::vector<PastTile> AllPastTiles(db::Connection* connection) {
  std::vector<PastTile> tiles;
  db::Statement row = connection->Prepare(kAllPastTilesSql);
  while (row.Step()) {
    tiles.push_back(
        {rows::ReadTile(*connection, row), MapVersion(row.Int64(14)), MapVersion(row.Int64(15))});
  }
  return tiles;
}

std::optional<KeyframeRecord> FindKeyframeOf(db::Connection* connection, MapVersion version,
                                             KeyframeId keyframe_id) {
  db::Statement head = connection->Prepare(
      "SELECT 1 FROM cairn_keyframe_poses WHERE keyframe_id = ? AND since <= ?");
  if (head.Bind(Value(keyframe_id), Value(version)).Step()) {
    return FindKeyframe(connection, keyframe_id);
  }
  db::Statement past = connection->Prepare(kPastKeyframeSql);
  if (!past.Bind(Value(keyframe_id), Value(version)).Step()) {
    return std::nullopt;
  }
  return rows::ReadKeyframe(*connection, past);
}

std::optional<GeoBox> BoundsOfTiles(db::Connection* connection) {
  std::vector<GeoBox> boxes;
  for (const int64_t tile_id : AllTileIds(connection)) {
    boxes.push_back(rows::ReadTileId(*connection, tile_id).Bounds());
  }
  return BoxAroundAll(std::move(boxes));
}

void InsertVersion(db::Connection* connection, MapVersion version, const VersionNote& note,
                   const MapTotals& totals) {
  connection
      ->Prepare(
          "INSERT INTO cairn_versions (version, created_at, author, kind, session, summary, "
          "codebook_id, num_sessions, num_keyframes, num_tiles, num_landmarks, num_descriptors, "
          "payload_bytes) VALUES (?, ?, ?, ?, ?, ?, "
          "(SELECT codebook_id FROM cairn_map), ?, ?, ?, ?, ?, ?)")
      .Bind(Value(version), UtcNow(), LoginName(), VersionKindName(note.kind), note.session,
            note.summary, totals.num_sessions, totals.num_keyframes, totals.num_tiles,
            totals.num_landmarks, totals.num_descriptors, totals.payload_bytes)
      .Run();
  if (totals.bounds) {
    connection
        ->Prepare(
            "UPDATE cairn_versions SET south_deg = ?, west_deg = ?, north_deg = ?, east_deg = ? "
            "WHERE version = ?")
        .Bind(totals.bounds->south_rad * kDegPerRad, totals.bounds->west_rad * kDegPerRad,
              totals.bounds->north_rad * kDegPerRad, totals.bounds->east_rad * kDegPerRad,
              Value(version))
        .Run();
  }
}

}  // namespace cairn::queries
