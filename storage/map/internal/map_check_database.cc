// The part of the check that needs only SQL.
#include <fmt/format.h>

#include <string>
#include <string_view>

#include "core/printable.h"
#include "storage/map/internal/accuracy_table.h"
#include "storage/map/internal/map_check.h"

namespace cairn {
namespace {

constexpr size_t kMaxLineBytes = 300;  // Limit on each line that SQLite reports.

void CheckSpatialIndices(db::Connection* connection, Findings* findings) {
  for (const char* index : {"rtree_coverage_geom", "rtree_keyframes_geom"}) {
    db::Statement tree = connection->Prepare("SELECT rtreecheck(?)");
    tree.Bind(std::string_view(index)).Step();
    if (const std::string line = tree.Text(0); line != "ok") {
      findings->Add(index, Excerpt(line, kMaxLineBytes));
    }
  }
}

// Checks only the tables of the map. Tables that other programs added are not Cairn's to check.
void CheckReferences(db::Connection* connection, Findings* findings) {
  for (const char* table :
       {"gpkg_contents", "gpkg_geometry_columns", "cairn_map", "cairn_versions", "cairn_tiles",
        "cairn_past_tiles", "cairn_keyframe_poses", "keyframes"}) {
    db::Statement references =
        connection->Prepare("SELECT coalesce(sum(1), 0) FROM pragma_foreign_key_check(?)");
    references.Bind(std::string_view(table)).Step();
    if (const int64_t count = references.Int64(0); count != 0) {
      findings->Add(fmt::format("table {}: {} rows refer to missing rows", table, count));
    }
  }
}

// Updates increment these numbers. From this bound on, a number could overflow.
#define CAIRN_TOO_LARGE "4611686018427387904"

constexpr Rule kTableRules[] = {
    {"SELECT count(*) FROM coverage WHERE tile_id NOT IN (SELECT tile_id FROM cairn_tiles)",
     "squares in coverage have no tile"},
    {"SELECT count(*) FROM coverage WHERE tile_id NOT IN (SELECT id FROM rtree_coverage_geom)",
     "tiles are missing in the spatial index"},
    {"SELECT count(*) FROM rtree_coverage_geom WHERE id NOT IN (SELECT tile_id FROM coverage)",
     "boxes of the spatial index belong to no tile"},
    {"SELECT count(*) FROM keyframes WHERE keyframe_id NOT IN (SELECT id FROM "
     "rtree_keyframes_geom)",
     "keyframes are missing in their spatial index"},
    {"SELECT count(*) FROM rtree_keyframes_geom "
     "WHERE id NOT IN (SELECT keyframe_id FROM keyframes)",
     "boxes of the spatial index belong to no keyframe"},
    {"SELECT count(*) FROM cairn_payloads "
     "WHERE payload_id NOT IN (SELECT payload_id FROM cairn_tiles) "
     "AND payload_id NOT IN (SELECT payload_id FROM cairn_past_tiles)",
     "payloads belong to no tile"},
    {"SELECT count(*) FROM cairn_tiles AS t JOIN coverage AS c ON c.tile_id = t.tile_id "
     "JOIN cairn_payloads AS p ON p.payload_id = t.payload_id WHERE length(p.bytes) <> c.num_bytes",
     "tiles have a payload size that differs from the one in coverage"},
    {"SELECT count(*) FROM keyframes "
     "WHERE keyframe_id NOT IN (SELECT keyframe_id FROM cairn_keyframe_poses)",
     "keyframes have no pose"},
    {"SELECT (SELECT coalesce(sum(1), 0) FROM cairn_map) <> 1", "table cairn_map: not one row",
     false},
    {"SELECT count(*) FROM cairn_map WHERE next_landmark_id >= " CAIRN_TOO_LARGE,
     "table cairn_map: the next landmark id is too large", false},
    {"SELECT coalesce(max(version), 0) NOT BETWEEN 1 AND " CAIRN_TOO_LARGE " FROM cairn_versions",
     "table cairn_versions: no version, or a version that is too large", false},
    {"SELECT count(*) FROM sqlite_sequence "
     "WHERE typeof(seq) <> 'integer' OR seq >= " CAIRN_TOO_LARGE,
     "id sequences are too large"},
    {"SELECT count(*) FROM cairn_sessions WHERE num_images < 0 OR num_landmarks < 0 "
     "OR NOT georef_median_residual_m BETWEEN 0 AND 1e9",
     "sessions have invalid numbers"},
    {"SELECT count(*) FROM cairn_sessions WHERE content_digest GLOB '*[^0-9a-f]*' "
     "OR recorded_at IS NOT strftime('%Y-%m-%dT%H:%M:%SZ', recorded_at)",
     "sessions have invalid times or digests"},
    // GeoPackage readers find the layers through these rows.
    {"SELECT 3 - count(*) FROM gpkg_contents WHERE (table_name, data_type) IN "
     "(VALUES ('coverage', 'features'), ('keyframes', 'features'), "
     "('cairn_sessions', 'attributes'))",
     "layers are missing in gpkg_contents"},
    {"SELECT 2 - count(*) FROM gpkg_geometry_columns WHERE (table_name, column_name, "
     "geometry_type_name, srs_id, z, m) IN (VALUES ('coverage', 'geom', 'POLYGON', 4326, 0, 0), "
     "('keyframes', 'geom', 'POINT', 4326, 1, 0))",
     "layers are missing in gpkg_geometry_columns"},
    {"SELECT 2 - count(*) FROM gpkg_extensions WHERE (table_name, column_name, extension_name) IN "
     "(VALUES ('coverage', 'geom', 'gpkg_rtree_index'), "
     "('keyframes', 'geom', 'gpkg_rtree_index'))",
     "spatial indices are missing in gpkg_extensions"},
    {"SELECT 1 - count(*) FROM gpkg_spatial_ref_sys WHERE srs_id = 4326 "
     "AND organization = 'EPSG' COLLATE NOCASE AND organization_coordsys_id = 4326",
     "WGS 84 is missing in gpkg_spatial_ref_sys"},
    {"SELECT count(*) FROM gpkg_contents AS c JOIN ("
     "SELECT 'coverage' AS layer, min(minx) AS west, min(miny) AS south, max(maxx) AS east, "
     "max(maxy) AS north FROM rtree_coverage_geom UNION ALL "
     "SELECT 'keyframes', min(minx), min(miny), max(maxx), max(maxy) FROM rtree_keyframes_geom"
     ") AS r ON c.table_name = r.layer WHERE r.west IS NOT NULL AND NOT coalesce("
     "abs(c.min_x - r.west) < 1e-3 AND abs(c.min_y - r.south) < 1e-3 AND "
     "abs(c.max_x - r.east) < 1e-3 AND abs(c.max_y - r.north) < 1e-3, 0)",
     "layers have a wrong extent in gpkg_contents"},
};

// The rules for PostgreSQL's tables.
constexpr Rule kPostgresRules[] = {
    {"SELECT count(*) FROM coverage WHERE tile_id NOT IN (SELECT tile_id FROM cairn_tiles)",
     "squares in coverage have no tile"},
    {"SELECT count(*) FROM cairn_payloads AS p "
     "WHERE NOT EXISTS (SELECT 1 FROM cairn_tiles AS t WHERE t.payload_id = p.payload_id) "
     "AND NOT EXISTS (SELECT 1 FROM cairn_past_tiles AS t WHERE t.payload_id = p.payload_id)",
     "payloads belong to no tile"},
    {"SELECT count(*) FROM keyframes AS k WHERE NOT EXISTS (SELECT 1 FROM cairn_keyframe_poses AS "
     "p "
     "WHERE p.keyframe_id = k.keyframe_id)",
     "keyframes have no pose"},
    {"SELECT (SELECT count(*) FROM cairn_map) <> 1", "table cairn_map: not one row", false},
    {"SELECT count(*) FROM cairn_map WHERE next_landmark_id >= " CAIRN_TOO_LARGE,
     "table cairn_map: the next landmark id is too large", false},
    {"SELECT coalesce(max(version), 0) NOT BETWEEN 1 AND " CAIRN_TOO_LARGE " FROM cairn_versions",
     "table cairn_versions: no version, or a version that is too large", false},
    {"SELECT count(*) FROM cairn_sessions WHERE num_images < 0 OR num_landmarks < 0 "
     "OR NOT georef_median_residual_m BETWEEN 0 AND 1e9",
     "sessions have invalid numbers"},
    {"SELECT count(*) FROM cairn_sessions WHERE content_digest !~ '^[0-9a-f]*$' "
     "OR recorded_at !~ '^\\d{4}-\\d\\d-\\d\\dT\\d\\d:\\d\\d:\\d\\dZ$'",
     "sessions have invalid times or digests"},
};

#undef CAIRN_TOO_LARGE

constexpr Rule kAccuracyRules[] = {
    {"SELECT count(*) FROM session_accuracy WHERE NOT (in_map_m BETWEEN 0 AND 1e7 AND "
     "on_earth_m BETWEEN 0 AND 1e7 AND on_earth_rad BETWEEN 0 AND 1e7)",
     "sessions have an impossible accuracy"},
};

// Maps of earlier programs lack the table.
void CheckAccuracies(db::Connection* connection, Findings* findings) {
  if (accuracy_table::Exists(connection)) {
    CheckRules(connection, kAccuracyRules, findings);
  }
}

}  // namespace

void CheckRules(db::Connection* connection, std::span<const Rule> rules, Findings* findings) {
  for (const Rule& rule : rules) {
    db::Statement row = connection->Prepare(rule.sql);
    row.Step();
    if (const int64_t count = row.Int64(0); count != 0) {
      findings->Add(rule.counts_rows ? fmt::format("{} {}", count, rule.problem) : rule.problem);
    }
  }
}

// Stops at the first problem. If damaged pages form a cycle, SQLite would count the rows of an
// index forever.
bool CheckPages(db::Connection* connection, Findings* findings) {
  bool are_sound = true;
  db::Statement pages = connection->Prepare("PRAGMA integrity_check(1)");
  while (pages.Step()) {
    if (const std::string line = pages.Text(0); line != "ok") {
      findings->Add("database", Excerpt(line, kMaxLineBytes));
      are_sound = false;
    }
  }
  return are_sound;
}

void CheckPostgresTables(db::Connection* connection, Findings* findings) {
  CheckRules(connection, kPostgresRules, findings);
  CheckAccuracies(connection, findings);
}

void CheckTables(db::Connection* connection, Findings* findings) {
  CheckSpatialIndices(connection, findings);
  CheckReferences(connection, findings);
  CheckRules(connection, kTableRules, findings);
  CheckAccuracies(connection, findings);
}

}  // namespace cairn
