#include "storage/map_check.h"

#include <limits>
#include <string>

#include "core/error.h"
#include "storage/map_queries.h"
#include "storage/tile_codec.h"

namespace cairn {
namespace {

// SQLite's own check of pages, indices, R*Trees and constraints, and of references between tables.
void CheckDatabase(sqlite::Connection* connection, CheckReport* report) {
  sqlite::Statement pages = connection->Prepare("PRAGMA integrity_check(20)");
  while (pages.Step()) {
    if (const std::string line = pages.Text(0); line != "ok") {
      report->problems.push_back("database: " + line);
    }
  }
  for (const char* index : {"rtree_coverage_geom", "rtree_keyframes_geom"}) {
    sqlite::Statement tree = connection->Prepare("SELECT rtreecheck(?)");
    tree.Bind(std::string_view(index)).Step();
    if (const std::string line = tree.Text(0); line != "ok") {
      report->problems.push_back(std::string(index) + ": " + line);
    }
  }
  sqlite::Statement references =
      connection->Prepare("SELECT \"table\", count(*) FROM pragma_foreign_key_check GROUP BY 1");
  while (references.Step()) {
    report->problems.push_back("table " + references.Text(0) + ": " +
                               std::to_string(references.Int64(1)) +
                               " rows refer to rows that are not there");
  }
}

// Numbers of rows that must agree because they describe the same things.
void CheckCounts(sqlite::Connection* connection, CheckReport* report) {
  struct Rule {
    const char* sql;
    const char* problem;
  };
  constexpr Rule kRules[] = {
      {"SELECT count(*) FROM coverage WHERE tile_id NOT IN (SELECT tile_id FROM cairn_tiles)",
       "squares in coverage have no tile"},
      {"SELECT count(*) FROM coverage WHERE tile_id NOT IN (SELECT id FROM rtree_coverage_geom)",
       "tiles are missing in the spatial index"},
      {"SELECT count(*) FROM cairn_payloads "
       "WHERE payload_id NOT IN (SELECT payload_id FROM cairn_tiles)",
       "payloads belong to no tile"},
      {"SELECT count(*) FROM keyframes "
       "WHERE keyframe_id NOT IN (SELECT keyframe_id FROM cairn_keyframe_poses)",
       "keyframes have no pose"},
  };
  for (const Rule& rule : kRules) {
    sqlite::Statement row = connection->Prepare(rule.sql);
    row.Step();
    if (row.Int64(0) != 0) {
      report->problems.push_back(std::to_string(row.Int64(0)) + " " + rule.problem);
    }
  }
}

void CheckTile(sqlite::Connection* connection, const TileRecord& record, CheckReport* report) {
  const auto complain = [&](const std::string& problem) {
    report->problems.push_back("tile " + record.tile_id.ToString() + ": " + problem);
  };
  try {
    const Tile tile = DecodeTile(queries::LoadPayload(connection, record.payload_id));
    if (tile.id != record.tile_id) {
      complain("its payload is that of tile " + tile.id.ToString());
    }
    if (tile.codebook_id != record.codebook_id) {
      complain("its payload names another codebook");
    }
    if (static_cast<int64_t>(tile.num_landmarks()) != record.num_landmarks ||
        static_cast<int64_t>(tile.num_descriptors()) != record.num_descriptors ||
        static_cast<int64_t>(tile.num_keyframes()) != record.num_keyframes) {
      complain("its counts are not those of its payload");
    }
    if (queries::LoadCodebook(connection, record.codebook_id)->num_subspaces != tile.code_size) {
      complain("its codes do not fit its codebook");
    }
  } catch (const Error& error) {
    complain(error.what());
  }
}

}  // namespace

CheckReport CheckMap(sqlite::Connection* connection,
                     const std::function<void(int64_t, int64_t)>& progress) {
  CheckReport report;
  try {
    CheckDatabase(connection, &report);
    CheckCounts(connection, &report);
    const std::vector<TileRecord> tiles =
        queries::AllTiles(connection, std::numeric_limits<int64_t>::max());
    for (const TileRecord& tile : tiles) {
      CheckTile(connection, tile, &report);
      ++report.num_tiles_checked;
      if (progress) {
        progress(report.num_tiles_checked, static_cast<int64_t>(tiles.size()));
      }
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kMapDamaged) {
      throw;
    }
    report.problems.push_back(error.what());
  }
  return report;
}

}  // namespace cairn
