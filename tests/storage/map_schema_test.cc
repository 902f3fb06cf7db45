// Tests maps with foreign tables, views and triggers, and maps whose pages refer to each other in
// circles.
#include "storage/map/internal/map_schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "core/error.h"
#include "storage/map/map_store.h"
#include "support/map_builder.h"
#include "support/raw_sql.h"
#include "support/street_map.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using testing::ExecuteRaw;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(TokenizeSql, WhiteSpaceAndCommentsDoNotCount) {
  EXPECT_EQ(TokenizeSql("CREATE TABLE t (\n  a TEXT, -- the a\n  b DEFAULT (f('x', 'now'))\n)"),
            TokenizeSql("CREATE TABLE t(a TEXT,/* b */b DEFAULT(f('x','now')))"));
}

TEST(TokenizeSql, WordsStayApart) {
  EXPECT_NE(TokenizeSql("a TEXT NOT NULL"), TokenizeSql("a TEXTNOT NULL"));
  EXPECT_THAT(TokenizeSql("a1 <= 'it''s' \"b c\"[d e]"),
              ElementsAre("a1", "<", "=", "'it''s'", "\"b c\"", "[d e]"));
}

TEST(TokenizeSql, QuotesAreNoComments) {
  EXPECT_THAT(TokenizeSql("'--' a"), ElementsAre("'--'", "a"));
  EXPECT_THAT(TokenizeSql("'a b"), ElementsAre("'a b"));
  EXPECT_THAT(TokenizeSql("/* a"), IsEmpty());
  EXPECT_NE(TokenizeSql("a, -- b\nc"), TokenizeSql("a, -- b c"));
}

class MapSchema : public ::testing::Test {
 protected:
  void ExpectRefused(const std::string& sql, const std::string& text) {
    const std::string path = testing::MakeStreetMap(dir_.File("a.gpkg"));
    ExecuteRaw(path, sql);
    for (const OpenMode mode : {OpenMode::kReadOnly, OpenMode::kReadWrite}) {
      try {
        MapStore::Open(path, mode);
        ADD_FAILURE() << "was opened";
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kMapDamaged) << error.what();
        EXPECT_THAT(error.what(), HasSubstr(text));
      }
    }
    std::filesystem::remove(path);
  }

  void ExpectTaken(const std::string& sql) {
    const std::string path = testing::MakeStreetMap(dir_.File("a.gpkg"));
    ExecuteRaw(path, sql);
    MapStore store = MapStore::Open(path, OpenMode::kReadWrite);
    EXPECT_THAT(store.Check({}).problems, IsEmpty());
    MapUpdate update = store.BeginUpdate();
    update.RemoveTile(store.Snapshot().AllTiles(1)[0].tile_id);
    update.RemoveSession(SessionId(2));
    update.Publish();
    std::filesystem::remove(path);
  }

  testing::TempDir dir_;
};

constexpr const char* kEndless =
    "(WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT count(*) FROM n)";

TEST_F(MapSchema, ViewsInPlaceOfTablesAreRefused) {
  ExpectRefused(
      "DROP TABLE cairn_versions; CREATE VIEW cairn_versions AS WITH RECURSIVE n(version) AS "
      "(SELECT 1 UNION ALL SELECT version + 1 FROM n) SELECT version, 'now' AS created_at FROM n",
      "cairn_versions");
}

TEST_F(MapSchema, ForeignViewsAreRefused) {
  ExpectRefused(std::string("CREATE VIEW mine AS SELECT ") + kEndless, "the view 'mine'");
  ExpectRefused("DROP VIEW v_map; CREATE VIEW v_map AS SELECT 1", "the view 'v_map'");
}

TEST_F(MapSchema, ForeignTriggersAreRefused) {
  ExpectRefused(std::string("CREATE TRIGGER mine AFTER UPDATE ON gpkg_contents BEGIN SELECT ") +
                    kEndless + "; END",
                "the trigger 'mine'");
  ExpectRefused(std::string("DROP TRIGGER rtree_keyframes_geom_insert; CREATE TRIGGER "
                            "rtree_keyframes_geom_insert AFTER INSERT ON keyframes BEGIN SELECT ") +
                    kEndless + "; END",
                "the trigger 'rtree_keyframes_geom_insert'");
}

TEST_F(MapSchema, TablesOfOtherColumnsAreRefused) {
  ExpectRefused("ALTER TABLE keyframes ADD COLUMN note TEXT", "the table 'keyframes'");
  ExpectRefused("DROP INDEX keyframes_by_session", "the index 'keyframes_by_session' is missing");
}

TEST_F(MapSchema, IndicesOnMapTablesAreRefused) {
  ExpectRefused("CREATE INDEX mine ON keyframes (hex(image_name))", "the index 'mine'");
}

TEST_F(MapSchema, TablesThatRunSqlOrHoldUpUpdatesAreRefused) {
  ExpectRefused("CREATE TABLE mine (a CHECK (length(hex(a)) > 0))", "checks or generated columns");
  ExpectRefused("CREATE TABLE mine (a, b AS (hex(a)))", "checks or generated columns");
  ExpectRefused("CREATE TABLE mine (a REFERENCES \"Coverage\" (tile_id))",
                "it references Cairn's tables");
  ExpectRefused("CREATE VIRTUAL TABLE mine USING rtree (id, a, b)", "it is a virtual table");
  ExpectRefused("CREATE TABLE cairn_mine (a)", "names that begin with cairn_ are reserved");
  ExpectRefused("CREATE TABLE mine (a); CREATE INDEX i ON mine (hex(a))",
                "it indexes expressions or a part of the rows");
  ExpectRefused("CREATE TABLE mine (a); CREATE INDEX i ON mine (a) WHERE a LIKE 'b'",
                "it indexes expressions or a part of the rows");
}

// As GDAL and QGIS make them.
TEST_F(MapSchema, PlainTablesOfOthersAreTaken) {
  ExpectTaken(
      "CREATE TABLE \"layer_styles\" (\"id\" INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, "
      "\"f_table_name\" TEXT(256), \"styleQML\" TEXT, \"useAsDefault\" BOOLEAN, \"update_time\" "
      "DATETIME DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')));"
      "INSERT INTO layer_styles (f_table_name) VALUES ('coverage');"
      "INSERT INTO gpkg_contents (table_name, data_type) VALUES ('layer_styles', 'attributes');"
      "CREATE TABLE gpkg_metadata (id INTEGER CONSTRAINT m_pk PRIMARY KEY ASC NOT NULL, md_scope "
      "TEXT NOT NULL DEFAULT 'dataset');"
      "CREATE TABLE gpkg_metadata_reference (md_file_id INTEGER NOT NULL, CONSTRAINT crmr_mfi_fk "
      "FOREIGN KEY (md_file_id) REFERENCES gpkg_metadata(id));"
      "CREATE INDEX mine ON layer_styles (f_table_name COLLATE NOCASE, \"styleQML\" DESC);"
      "ANALYZE");
}

// A foreign key without a matching parent made SQLite's check of references fail.
TEST_F(MapSchema, ForeignKeysOfOthersThatDoNotFitAreTheirs) {
  ExpectTaken("CREATE TABLE mine (a REFERENCES nowhere (b)); INSERT INTO mine VALUES (1)");
}

TEST_F(MapSchema, MapsOfEarlierCommitsDifferInWhiteSpaceOnly) {
  ExpectTaken(
      "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = replace(sql, 'fZ'',''now''', "
      "'fZ'',  ''now''') WHERE name = 'gpkg_contents'");
}

TEST_F(MapSchema, SumsThatOverflowAreDamage) {
  const std::string path = testing::MakeStreetMap(dir_.File("a.gpkg"));
  ExecuteRaw(path, "UPDATE coverage SET num_landmarks = 9223372036854775807");
  MapStore store = MapStore::Open(path, OpenMode::kReadWrite);
  EXPECT_THAT(store.Check({}).problems, ::testing::Contains(HasSubstr("integer overflow")));
  EXPECT_EQ(testing::ErrorCodeOf([&] {
              MapUpdate update = store.BeginUpdate();
              update.RemoveTile(store.Snapshot().AllTiles(1).at(0).tile_id);
              update.Publish();
            }),
            ErrorCode::kMapDamaged);
}

}  // namespace
}  // namespace cairn
