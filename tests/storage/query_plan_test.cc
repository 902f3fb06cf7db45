// Tests that the frequent queries find their rows through an index.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "storage/map/internal/map_file.h"
#include "storage/map/internal/map_queries.h"
#include "storage/map/internal/tile_pages.h"
#include "storage/map/internal/version_queries.h"
#include "support/street_map.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using testing::MakeStreetMap;
using ::testing::Not;
using testing::TempDir;

// The steps of the plan, one a line.
std::string PlanOf(const std::string& path, std::string_view sql) {
  sqlite::Access access = sqlite::Access::kReadOnly;
  const auto connection = OpenMapFile(path, &access);
  sqlite::Statement rows = connection->Prepare("EXPLAIN QUERY PLAN " + std::string(sql));
  std::string plan;
  while (rows.Step()) {
    plan += rows.Text(3) + "\n";
  }
  return plan;
}

TEST(QueryPlan, TilesOfABoxComeThroughTheRTree) {
  const TempDir dir;
  const std::string plan = PlanOf(MakeStreetMap(dir.File("a.gpkg")), queries::FindTilesSql());
  EXPECT_THAT(plan, HasSubstr("SCAN r VIRTUAL TABLE INDEX 2:"));
  EXPECT_THAT(plan, HasSubstr("SEARCH c USING INTEGER PRIMARY KEY"));
  EXPECT_THAT(plan, HasSubstr("SEARCH t USING INTEGER PRIMARY KEY"));
  EXPECT_THAT(plan, Not(HasSubstr("SCAN c")));
  EXPECT_THAT(plan, Not(HasSubstr("SCAN t")));
}

TEST(QueryPlan, PagesOfTilesReadNoMoreThanTheyNeed) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  EXPECT_THAT(PlanOf(path, queries::TileIdsInBoxSql()), HasSubstr("VIRTUAL TABLE INDEX 2:"));
  const std::string plan = PlanOf(path, queries::TileIdsAfterSql());
  EXPECT_THAT(plan, HasSubstr("SEARCH coverage USING INTEGER PRIMARY KEY (rowid>?)"));
  EXPECT_THAT(plan, Not(HasSubstr("TEMP B-TREE")));
}

TEST(QueryPlan, ATileComesByItsKey) {
  const TempDir dir;
  const std::string plan = PlanOf(MakeStreetMap(dir.File("a.gpkg")), queries::FindTileSql());
  EXPECT_THAT(plan, Not(HasSubstr("SCAN")));
}

TEST(QueryPlan, TilesOfAListComeByTheirKeys) {
  const TempDir dir;
  const std::string plan = PlanOf(MakeStreetMap(dir.File("a.gpkg")), queries::TilesWithIdsSql());
  EXPECT_THAT(plan, HasSubstr("SEARCH c USING INTEGER PRIMARY KEY"));
  EXPECT_THAT(plan, HasSubstr("SEARCH t USING INTEGER PRIMARY KEY"));
  EXPECT_THAT(plan, Not(HasSubstr("SCAN c")));
  EXPECT_THAT(plan, Not(HasSubstr("SCAN t")));
}

TEST(QueryPlan, KeyframesAndTilesOfASessionComeThroughItsIndex) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  const std::string keyframes = PlanOf(path, queries::KeyframesOfSessionSql());
  EXPECT_THAT(keyframes, HasSubstr("INDEX keyframes_by_session (session_id=?)"));
  EXPECT_THAT(keyframes, Not(HasSubstr("SCAN")));
  const std::string tiles = PlanOf(path, queries::TilesOfSessionSql());
  EXPECT_THAT(tiles, HasSubstr("PRIMARY KEY (session_id=?)"));
  EXPECT_THAT(tiles, Not(HasSubstr("SCAN")));
}

TEST(QueryPlan, KeyframesOfATileComeThroughItsIndex) {
  const TempDir dir;
  const std::string plan = PlanOf(MakeStreetMap(dir.File("a.gpkg")), queries::KeyframesOfTileSql());
  EXPECT_THAT(plan, HasSubstr("INDEX keyframes_by_tile (tile_id=?)"));
  EXPECT_THAT(plan, Not(HasSubstr("SCAN")));
}

TEST(QueryPlan, TheVersionIsOneStepFromTheEnd) {
  const TempDir dir;
  const std::string plan = PlanOf(MakeStreetMap(dir.File("a.gpkg")), queries::LatestVersionSql());
  EXPECT_THAT(plan, Not(HasSubstr("TEMP B-TREE")));
  EXPECT_THAT(PlanOf(dir.File("a.gpkg"), queries::LatestVersionsSql()),
              Not(HasSubstr("TEMP B-TREE")));
}

TEST(QueryPlan, PastTilesComeByTheirKeys) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  for (const std::string_view sql :
       {queries::PastTilesWithIdsSql(), queries::PastTilesOfPageSql()}) {
    const std::string plan = PlanOf(path, sql);
    EXPECT_THAT(plan, HasSubstr("SEARCH t USING PRIMARY KEY (tile_id"));
    EXPECT_THAT(plan, Not(HasSubstr("SCAN t")));
  }
}

TEST(QueryPlan, WhatChangedComesThroughIndices) {
  const TempDir dir;
  const std::string plan = PlanOf(MakeStreetMap(dir.File("a.gpkg")), queries::ChangedTilesSql());
  EXPECT_THAT(plan, HasSubstr("INDEX cairn_tiles_by_since (since>?)"));
  EXPECT_THAT(plan, HasSubstr("INDEX cairn_past_tiles_by_until (until>?)"));
}

}  // namespace
}  // namespace cairn
