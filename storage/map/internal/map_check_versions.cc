// The part of the check that reads the versions and the past.
#include <optional>
#include <string>

#include "core/error.h"
#include "storage/map/internal/map_check.h"
#include "storage/map/internal/map_queries.h"
#include "storage/map/internal/version_queries.h"

namespace cairn {
namespace {

constexpr Rule kVersionRules[] = {
    {"SELECT max(version) - min(version) + 1 <> count(*) FROM cairn_versions",
     "table cairn_versions: versions are missing", false},
    {"SELECT coalesce((SELECT codebook_id FROM cairn_versions ORDER BY version DESC LIMIT 1), 0) "
     "<> coalesce((SELECT codebook_id FROM cairn_map), 0)",
     "table cairn_map: its codebook is not the codebook of the latest version", false},
    {"SELECT count(*) FROM (SELECT since FROM cairn_tiles UNION ALL "
     "SELECT since FROM cairn_sessions UNION ALL SELECT since FROM cairn_keyframe_poses) AS r "
     "WHERE since NOT BETWEEN 1 AND (SELECT max(version) FROM cairn_versions)",
     "rows are from versions that the map never had"},
    {"SELECT count(*) FROM (SELECT since, until FROM cairn_past_tiles UNION ALL "
     "SELECT since, until FROM cairn_past_sessions UNION ALL "
     "SELECT since, until FROM cairn_past_keyframes) AS r WHERE since < 1 "
     "OR until <= (SELECT min(version) FROM cairn_versions) "
     "OR until > (SELECT max(version) FROM cairn_versions)",
     "rows of the past belong to versions that the map does not have"},
    {"SELECT count(*) FROM cairn_past_tiles AS a "
     "JOIN cairn_past_tiles AS b ON b.tile_id = a.tile_id AND b.since > a.since "
     "WHERE b.since < a.until",
     "tiles of the past appear twice in one version"},
    {"SELECT count(*) FROM cairn_past_keyframes AS a "
     "JOIN cairn_past_keyframes AS b ON b.keyframe_id = a.keyframe_id AND b.since > a.since "
     "WHERE b.since < a.until",
     "keyframes of the past appear twice in one version"},
    {"SELECT count(*) FROM cairn_past_sessions AS a "
     "JOIN cairn_past_sessions AS b ON b.session_id = a.session_id AND b.since > a.since "
     "WHERE b.since < a.until",
     "sessions of the past appear twice in one version"},
    {"SELECT count(*) FROM cairn_past_tiles AS p "
     "JOIN cairn_tiles AS t ON t.tile_id = p.tile_id WHERE t.since < p.until",
     "tiles are in the map and in its past in one version"},
    {"SELECT count(*) FROM cairn_past_keyframes AS p "
     "JOIN cairn_keyframe_poses AS k ON k.keyframe_id = p.keyframe_id WHERE k.since < p.until",
     "keyframes are in the map and in its past in one version"},
    {"SELECT count(*) FROM cairn_past_sessions AS p "
     "JOIN cairn_sessions AS s ON s.session_id = p.session_id WHERE s.since < p.until",
     "sessions are in the map and in its past in one version"},
    {"SELECT count(*) FROM cairn_past_keyframes "
     "WHERE camera_id NOT IN (SELECT camera_id FROM cairn_cameras)",
     "keyframes of the past have no camera"},
    {"SELECT count(*) FROM cairn_versions WHERE CASE num_tiles WHEN 0 "
     "THEN coalesce(south_deg, west_deg, north_deg, east_deg) IS NULL "
     "ELSE south_deg BETWEEN -90 AND north_deg AND north_deg <= 90 "
     "AND west_deg BETWEEN -180 AND 180 AND east_deg BETWEEN -180 AND 180 END IS NOT TRUE",
     "versions have invalid bounds"},
    // Each row is an event: it adds to the totals in `since` and subtracts from them in `until`.
    {"WITH events (version, tiles, landmarks, descriptors, bytes, keyframes, sessions) AS ("
     "SELECT version, 0, 0, 0, 0, 0, 0 FROM cairn_versions UNION ALL "
     "SELECT t.since, 1, c.num_landmarks, c.num_descriptors, c.num_bytes, 0, 0 "
     "FROM cairn_tiles AS t JOIN coverage AS c ON c.tile_id = t.tile_id UNION ALL "
     "SELECT since, 1, num_landmarks, num_descriptors, num_bytes, 0, 0 "
     "FROM cairn_past_tiles UNION ALL "
     "SELECT until, -1, -num_landmarks, -num_descriptors, -num_bytes, 0, 0 "
     "FROM cairn_past_tiles UNION ALL "
     "SELECT since, 0, 0, 0, 0, 1, 0 FROM cairn_keyframe_poses UNION ALL "
     "SELECT since, 0, 0, 0, 0, 1, 0 FROM cairn_past_keyframes UNION ALL "
     "SELECT until, 0, 0, 0, 0, -1, 0 FROM cairn_past_keyframes UNION ALL "
     "SELECT since, 0, 0, 0, 0, 0, 1 FROM cairn_sessions UNION ALL "
     "SELECT since, 0, 0, 0, 0, 0, 1 FROM cairn_past_sessions UNION ALL "
     "SELECT until, 0, 0, 0, 0, 0, -1 FROM cairn_past_sessions"
     "), sums AS (SELECT version, sum(tiles) AS tiles, sum(landmarks) AS landmarks, "
     "sum(descriptors) AS descriptors, sum(bytes) AS bytes, sum(keyframes) AS keyframes, "
     "sum(sessions) AS sessions FROM events GROUP BY version"
     "), totals AS (SELECT version, sum(tiles) OVER w AS tiles, sum(landmarks) OVER w AS "
     "landmarks, "
     "sum(descriptors) OVER w AS descriptors, sum(bytes) OVER w AS bytes, "
     "sum(keyframes) OVER w AS keyframes, sum(sessions) OVER w AS sessions "
     "FROM sums WINDOW w AS (ORDER BY version)) "
     "SELECT count(*) FROM cairn_versions AS v JOIN totals AS t ON t.version = v.version "
     "WHERE (v.num_tiles, v.num_landmarks, v.num_descriptors, v.payload_bytes, v.num_keyframes, "
     "v.num_sessions) <> (t.tiles, t.landmarks, t.descriptors, t.bytes, t.keyframes, t.sessions)",
     "versions have totals that do not match their content"},
};

// Only for SQLite: PostgreSQL's date functions would throw on an invalid time.
constexpr Rule kTimeRules[] = {
    {"SELECT count(*) FROM cairn_versions "
     "WHERE created_at IS NOT strftime('%Y-%m-%dT%H:%M:%SZ', created_at)",
     "versions have invalid times"},
};

void CheckPastKeyframes(db::Connection* connection, Findings* findings) {
  db::Statement row = connection->Prepare("SELECT keyframe_id, since FROM cairn_past_keyframes");
  while (row.Step()) {
    try {
      queries::FindKeyframeOf(connection, MapVersion(row.Int64(1)), KeyframeId(row.Int64(0)));
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kMapDamaged) {
        throw;
      }
      findings->Add("a keyframe of the past", error.what());
    }
  }
}

}  // namespace

void CheckVersions(db::Connection* connection, Findings* findings) {
  CheckRules(connection, kVersionRules, findings);
  if (connection->dialect() == db::Dialect::kSqlite) {
    CheckRules(connection, kTimeRules, findings);
  }
  const VersionRecord latest = queries::LatestRecord(connection);
  const std::optional<GeoBox> bounds = queries::BoundsOfTiles(connection);
  const std::optional<GeoBox>& stored = latest.totals.bounds;
  if (bounds.has_value() != stored.has_value() || (bounds && !SameBounds(*bounds, *stored))) {
    findings->Add("the bounds of the latest version do not match its tiles");
  }
  CheckPastKeyframes(connection, findings);
}

}  // namespace cairn
