// --options through the real binaries.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/run_cairn.h"
#include "core/error.h"
#include "http/client.h"
#include "ingest/colmap/write_colmap.h"
#include "storage/map/map_store.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class OptionsFile : public ::testing::Test {
 protected:
  OptionsFile() {
    MapStore::Create(map_);
    WriteColmapModel(street_, dir_.path().string(), ColmapModelFormat::kBinary);
    WriteColmapDatabase(street_, dir_.File("database.db"), {});
  }

  // The path of an options file that holds `json`.
  std::string Options(const std::string& json) const {
    std::ofstream(dir_.File("options.json"), std::ios::binary) << json;
    return dir_.File("options.json");
  }

  // The summary of `cairn ingest` of a street with these options into a new map.
  nlohmann::json Ingest(std::vector<std::string> arguments) {
    std::filesystem::remove(map_);
    MapStore::Create(map_);
    arguments.insert(arguments.begin(),
                     {"ingest", map_, "--model", dir_.path().string(), "--database",
                      dir_.File("database.db"), "--gps", "--session", "street", "--json"});
    const Finished finished = RunCairn(arguments);
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    return nlohmann::json::parse(finished.out);
  }

  const TempDir dir_;
  const std::string map_ = dir_.File("map.gpkg");
  const Reconstruction street_ = StreetWorld().Reconstruct();
};

TEST_F(OptionsFile, DefaultsThatArePrintedAreTaken) {
  const std::string defaults = RunCairn({"options"}).out;
  EXPECT_EQ(nlohmann::json::parse(defaults)["matching"]["max_neighbors"], 4);
  const auto plain = Ingest({});
  EXPECT_EQ(Ingest({"--options", Options(defaults)})["descriptors"], plain["descriptors"]);
}

TEST_F(OptionsFile, AMistakeIsAUsageErrorOfEveryVerbThatTakesOne) {
  const std::string path = Options(R"({"voting": {"max_candidate": 8}})");
  const std::vector<std::vector<std::string>> verbs = {
      {"serve", map_},
      {"localize", map_, "--image", "photo.jpg"},
      {"eval", map_, "--queries", "queries.json"},
      {"ingest", map_, "--model", "m", "--database", "d", "--gps"},
      {"merge", map_, map_, "--out", dir_.File("c.gpkg")}};
  for (std::vector<std::string> arguments : verbs) {
    arguments.insert(arguments.end(), {"--options", path});
    const Finished finished = RunCairn(arguments);
    EXPECT_EQ(finished.exit_code, 2) << arguments[0];
    EXPECT_THAT(finished.err, AllOf(HasSubstr(path + ": voting.max_candidate is not an option"),
                                    HasSubstr("voting.max_candidates")))
        << arguments[0];
  }
  EXPECT_EQ(RunCairnLab({"bench", "--options", path}).exit_code, 2);
}

TEST_F(OptionsFile, WhatIsNoJsonOrNoFileIsBadInput) {
  EXPECT_EQ(RunCairn({"serve", map_, "--options", Options("{")}).exit_code, 4);
  EXPECT_EQ(RunCairn({"serve", map_, "--options", dir_.File("none.json")}).exit_code, 4);
}

TEST_F(OptionsFile, FlagsWinWhereverTheyStand) {
  const std::string few = Options(R"({"ingest": {"selection": {"max_descriptors": 100}}})");
  const int64_t all = Ingest({})["descriptors"];
  const int64_t limited = Ingest({"--options", few})["descriptors"];
  EXPECT_LT(limited, all);
  EXPECT_EQ(Ingest({"--options", few, "--max-descriptors", "500000"})["descriptors"], all);
  EXPECT_EQ(Ingest({"--max-descriptors", "500000", "--options", few})["descriptors"], all);
}

TEST_F(OptionsFile, IngestSelectsLandmarksByTheIntegerProgram) {
  const std::string coverage = R"({"ingest": {"selection": {"max_landmarks": 60)";
  // What is for coverage only does nothing without it.
  const int64_t all = Ingest({})["landmarks"];
  EXPECT_EQ(Ingest({"--options", Options(coverage + "}}}")})["landmarks"], all);
  const int64_t by_flag =
      Ingest({"--options", Options(coverage + "}}}"), "--selection", "coverage"})["landmarks"];
  const int64_t by_file =
      Ingest({"--options", Options(coverage + R"(, "kind": "coverage"}}})")})["landmarks"];
  EXPECT_LT(by_flag, all);
  EXPECT_EQ(by_flag, by_file);
  const Finished refused = RunCairn({"ingest", map_, "--selection", "best"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("observation_count"), HasSubstr("coverage")));
}

TEST_F(OptionsFile, ServeTakesLimitsFromTheFile) {
  Ingest({});
  BackgroundCairn server({"serve", map_, "--port", "0", "--log-level", "off", "--options",
                          Options(R"({"server": {"max_features": 3}})")});
  LocalizeClient client(ClientOptions{.url = server.ReadLine()});
  LocalizeQuery query;
  query.camera = street_.cameras[0];
  query.features = street_.images[0].features.Unpacked();
  ASSERT_GT(query.features.size(), 3);
  try {
    client.LocalizeFeatures(query);
    FAIL() << "more features than the limit";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("3"));
  }
  EXPECT_EQ(server.Stop(SIGTERM), 0);
}

TEST_F(OptionsFile, ThePageOfOptionsIsTheOneThatIsPrinted) {
  std::ifstream file(CAIRN_SOURCE_DIR "/docs/options.md", std::ios::binary);
  const std::string page{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  EXPECT_EQ(page, RunCairn({"options", "--markdown"}).out)
      << "run `cairn options --markdown > docs/options.md`";
}

}  // namespace
}  // namespace cairn::testing
