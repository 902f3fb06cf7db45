#include "storage/map/internal/map_check.h"

#include <fmt/format.h>

#include <set>
#include <string>
#include <vector>

#include "core/error.h"
#include "storage/map/internal/map_queries.h"

namespace cairn {

void Findings::Add(const std::string& where, const std::string& problem) {
  constexpr int64_t kMaxOfAKind = 10;
  constexpr size_t kMaxProblems = 1000;
  if (report_->problems.size() >= kMaxProblems) {
    ++num_left_out_["problems that are not listed"];
  } else if (++count_of_problem_[problem] <= kMaxOfAKind) {
    report_->problems.push_back(where.empty() ? problem : where + ": " + problem);
  } else {
    ++num_left_out_[problem];
  }
}

void Findings::Add(const std::string& problem) { Add("", problem); }

void Findings::Finish() {
  for (const auto& [problem, count] : num_left_out_) {
    report_->problems.push_back(fmt::format("{} more: {}", count, problem));
  }
}

namespace {

// Checks everything but the tiles.
void CheckTablesOf(db::Connection* connection, Findings* findings) {
  if (connection->dialect() == db::Dialect::kPostgres) {
    CheckPostgresTables(connection, findings);
    CheckLayers(connection, findings);
    CheckVersions(connection, findings);
  } else if (CheckPages(connection, findings)) {
    CheckTables(connection, findings);
    CheckLayers(connection, findings);
    CheckVersions(connection, findings);
  }
  CheckCodebooks(connection, findings);
}

// Checks the tiles of the latest version and of the past.
void CheckTiles(db::Connection* connection, const std::function<void(int64_t, int64_t)>& progress,
                int64_t* num_checked, Findings* findings) {
  // A damaged page may list the same tile more than once.
  const std::vector<int64_t> in_pages = queries::AllTileIds(connection);
  const std::set<int64_t> tile_ids(in_pages.begin(), in_pages.end());
  const std::vector<queries::PastTile> past_tiles = queries::AllPastTiles(connection);
  const auto num_tiles = static_cast<int64_t>(tile_ids.size() + past_tiles.size());
  const auto count_tile = [&] {
    ++*num_checked;
    if (progress) {
      progress(*num_checked, num_tiles);
    }
  };
  for (const int64_t tile_id : tile_ids) {
    CheckTile(connection, tile_id, findings);
    count_tile();
  }
  for (const queries::PastTile& tile : past_tiles) {
    CheckPastTile(connection, tile, findings);
    count_tile();
  }
}

}  // namespace

CheckReport CheckMap(db::Connection* connection,
                     const std::function<void(int64_t, int64_t)>& progress) {
  CheckReport report;
  Findings findings(&report);
  try {
    CheckTablesOf(connection, &findings);
    CheckTiles(connection, progress, &report.num_tiles_checked, &findings);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kMapDamaged) {
      throw;
    }
    findings.Add(error.what());
  }
  findings.Finish();
  return report;
}

}  // namespace cairn
