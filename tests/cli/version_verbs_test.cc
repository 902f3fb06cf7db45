// Tests the verbs that work on versions and on whole maps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/run_cairn.h"
#include "storage/map/map_store.h"
#include "support/places.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

// A map of three versions with content: place 0, place 1, place 0 again.
class VersionVerbs : public ::testing::Test {
 protected:
  VersionVerbs() { MakeMap(map_, {0, 1, 0}, "place "); }

  static void MakeMap(const std::string& path, const std::vector<int>& places,
                      const std::string& prefix) {
    MapStore store = MapStore::Create(path);
    uint64_t seed = 0;
    for (const int place : places) {
      MapUpdate update = store.BeginUpdate();
      PutPlace(place, ++seed, &update, 20, prefix);
      update.Publish({VersionKind::kIngest, NameOfPlace(place, prefix), "a test"});
    }
  }

  static Json RunForJson(const std::vector<std::string>& arguments) {
    const Finished finished = RunCairn(arguments);
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    return Json::parse(finished.out);
  }

  static void ExpectFails(const std::vector<std::string>& arguments, int exit_code,
                          const std::string& text) {
    const Finished finished = RunCairn(arguments);
    EXPECT_EQ(finished.exit_code, exit_code);
    EXPECT_THAT(finished.err, HasSubstr(text));
  }

  TempDir dir_;
  const std::string map_ = dir_.File("map.gpkg");
};

TEST_F(VersionVerbs, LogListsTheVersions) {
  const Json log = RunForJson({"log", map_, "--json"});
  ASSERT_EQ(log.size(), 4u);
  EXPECT_EQ(log[0]["version"], 4);
  EXPECT_EQ(log[0]["kind"], "ingest");
  EXPECT_EQ(log[0]["session"], "place 0");
  EXPECT_EQ(log[0]["tiles"], 2);
  EXPECT_NE(log[0]["author"], "");
  EXPECT_EQ(RunForJson({"log", map_, "--json", "--limit", "1"}).size(), 1u);
  EXPECT_THAT(RunCairn({"log", map_}).out, HasSubstr("ingest   place 0: a test"));
  ExpectFails({"log", map_, "--limit", "0"}, 2, "'0' is not a number above 0");
}

TEST_F(VersionVerbs, DiffShowsTilesLandmarksAndBytes) {
  const Json diff = RunForJson({"diff", map_, "2", "4", "--json"});
  EXPECT_EQ(diff["tilesAdded"], 1);
  EXPECT_EQ(diff["tilesReplaced"], 1);
  EXPECT_EQ(diff["tilesRemoved"], 0);
  EXPECT_EQ(diff["landmarks"], 20);
  EXPECT_GT(diff["bytes"], 0);
  EXPECT_EQ(diff["tiles"].size(), 2u);
  const Json features = RunForJson({"diff", map_, "2", "4", "--geojson"});
  EXPECT_EQ(features["type"], "FeatureCollection");
  EXPECT_EQ(features["features"][0]["geometry"]["coordinates"][0].size(), 5u);
  EXPECT_THAT(RunCairn({"diff", map_, "2", "4"}).out,
              HasSubstr("1 tiles added, 1 replaced, 0 removed; +20 landmarks, "));
  EXPECT_THAT(RunCairn({"diff", map_}).out, HasSubstr("version 3 -> 4\n"));
  EXPECT_THAT(RunCairn({"diff", map_, "2"}).out, HasSubstr("version 2 -> 4\n"));
  ExpectFails({"diff", map_, "2", "9"}, 4, "it has versions 1 to 4");
}

TEST_F(VersionVerbs, RollbackGoesBack) {
  EXPECT_THAT(RunCairn({"rollback", map_, "2"}).out, HasSubstr("now version 5"));
  EXPECT_TRUE(RunForJson({"diff", map_, "2", "5", "--json"})["tiles"].empty());
  EXPECT_EQ(RunCairn({"check", map_}).exit_code, 0);
  ExpectFails({"rollback", map_, "77"}, 4, "it has versions 1 to 5");
}

TEST_F(VersionVerbs, PruneAndCompactMakeTheFileSmaller) {
  EXPECT_THAT(RunCairn({"prune", map_, "--keep", "1"}).out, HasSubstr("deleted 4 versions"));
  EXPECT_THAT(RunCairn({"prune", map_, "--older-than", "2020-01-01"}).out,
              HasSubstr("deleted 0 versions"));
  EXPECT_EQ(RunCairn({"compact", map_}).exit_code, 0);
  EXPECT_EQ(RunCairn({"check", map_}).exit_code, 0);
  EXPECT_EQ(RunForJson({"info", map_, "--json"})["tiles"], 2);
  ExpectFails({"prune", map_}, 2, "either a number of versions");
  ExpectFails({"prune", map_, "--older-than", "soon"}, 2, "older_than");
  ExpectFails({"rollback", map_, "2"}, 4, "it has version 5 only");
}

TEST_F(VersionVerbs, MergeMakesOneMapOfTwo) {
  const std::string other = dir_.File("other.gpkg"), merged = dir_.File("merged.gpkg");
  MakeMap(other, {1, 2}, "other ");
  EXPECT_THAT(RunCairn({"merge", map_, other, "--out", merged}).out,
              HasSubstr("4 sessions, 3 tiles (1 of them in both maps), 80 landmarks"));
  EXPECT_EQ(RunCairn({"check", merged}).exit_code, 0);
  EXPECT_EQ(RunForJson({"info", merged, "--json"})["codebook"],
            RunForJson({"info", map_, "--json"})["codebook"]);
  ExpectFails({"merge", map_, map_, "--out", dir_.File("no.gpkg")}, 4, "both have a session");
  ExpectFails({"merge", map_, other, "--out", merged}, 4, "already exists");
}

TEST_F(VersionVerbs, ExtractTakesABoxOrAGeoJsonFile) {
  const std::string part = dir_.File("part.gpkg"), region = dir_.File("region.geojson");
  EXPECT_THAT(RunCairn({"extract", map_, "--bbox", "49,8.4,49.1,8.5", "--out", part}).out,
              HasSubstr("2 sessions, 2 tiles, 40 landmarks"));
  EXPECT_EQ(RunCairn({"check", part}).exit_code, 0);
  const Geodetic here = TileOfPlace(1).Anchor();
  std::ofstream(region) << Json({{"type", "Feature"},
                                 {"geometry",
                                  {{"type", "Polygon"},
                                   {"coordinates",
                                    {{{here.lon_deg(), here.lat_deg()},
                                      {here.lon_deg() + 1e-5, here.lat_deg()},
                                      {here.lon_deg(), here.lat_deg() + 1e-5}}}}}}});
  EXPECT_THAT(RunCairn({"extract", map_, "--geojson", region, "--out", dir_.File("one.gpkg")}).out,
              HasSubstr("1 sessions, 1 tiles, 20 landmarks"));
  const std::string none = dir_.File("none.gpkg");
  ExpectFails({"extract", map_, "--bbox", "0,0,1,1", "--out", none}, 4, "no tile in this region");
  ExpectFails({"extract", map_, "--bbox", "2,0,1,1", "--out", none}, 4,
              "southern edge north of its northern edge");
  ExpectFails({"extract", map_, "--out", none}, 2, "");
  std::ofstream(region) << R"({"type": "Point", "coordinates": [8, 49]})";
  ExpectFails({"extract", map_, "--geojson", region, "--out", none}, 4, "a kind of polygon");
  std::ofstream(region) << "[[1";
  ExpectFails({"extract", map_, "--geojson", region, "--out", none}, 4, "region.geojson");
  EXPECT_FALSE(std::filesystem::exists(none));
}

}  // namespace
}  // namespace cairn::testing
