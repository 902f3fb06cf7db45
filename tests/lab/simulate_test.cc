// Tests `cairn-lab simulate`, and the other verbs on its files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/exit_codes.h"
#include "cli/run_cairn.h"
#include "core/file_bytes.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;

constexpr uint64_t kMaxBytes = 1 << 20;

class Simulate : public ::testing::Test {
 protected:
  // A quick city with what is given.
  Finished Run(const std::vector<std::string>& arguments) {
    std::vector<std::string> all = {"simulate", "--size", "quick"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return RunCairnLab(all);
  }

  TempDir dir_;
};

TEST_F(Simulate, EvalLocalizesTheQueriesInTheMap) {
  const Finished made =
      Run({"--map", dir_.File("map.gpkg"), "--queries", dir_.File("queries.json")});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("20 in "));
  const Finished evaluated =
      RunCairn({"eval", dir_.File("map.gpkg"), "--queries", dir_.File("queries.json"),
                "--given-priors", "--json", dir_.File("report.json")});
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  const auto report = nlohmann::json::parse(ReadTextFile(dir_.File("report.json"), kMaxBytes));
  EXPECT_EQ(report["num_queries"], 20);
  EXPECT_GE(report["num_localized"], 5);
  EXPECT_LT(report["median_position_error_m"]["value"], 2.0);
}

TEST_F(Simulate, EvalSearchesWithTheIndexThatIsChosen) {
  ASSERT_EQ(Run({"--map", dir_.File("map.gpkg"), "--queries", dir_.File("queries.json")}).exit_code,
            0);
  const auto localized_with = [&](const std::string& index) {
    const Finished evaluated =
        RunCairn({"eval", dir_.File("map.gpkg"), "--queries", dir_.File("queries.json"),
                  "--given-priors", "--index", index, "--json", dir_.File("report.json")});
    EXPECT_EQ(evaluated.exit_code, 0) << evaluated.err;
    return nlohmann::json::parse(ReadTextFile(dir_.File("report.json"), kMaxBytes))["num_localized"]
        .get<int>();
  };
  for (const char* index : {"random_grids", "inverted_lists"}) {
    EXPECT_GE(localized_with(index), 5) << index;
  }
  const Finished refused = RunCairn({"eval", dir_.File("map.gpkg"), "--queries",
                                     dir_.File("queries.json"), "--index", "nonsense"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("is not one of random_grids, inverted_lists"));
}

TEST_F(Simulate, TheSameSeedMakesTheSameQueries) {
  for (const char* name : {"a", "b"}) {
    const std::string base = dir_.File(name);
    ASSERT_EQ(Run({"--map", base + ".gpkg", "--queries", base + ".json", "--num-queries", "3",
                   "--seed", "7", "--threads", name == std::string("a") ? "1" : "3"})
                  .exit_code,
              0);
  }
  for (const char* query : {"phone_000000.features", "phone_000002.features"}) {
    const auto a = ReadFileBytes(dir_.File("a_features/" + std::string(query)), kMaxBytes);
    EXPECT_GT(a.size(), 10'000u);
    EXPECT_EQ(a, ReadFileBytes(dir_.File("b_features/" + std::string(query)), kMaxBytes));
  }
}

TEST_F(Simulate, IngestReadsTheColmapFilesBack) {
  ASSERT_EQ(Run({"--colmap", dir_.File("colmap"), "--clutter", "0.5"}).exit_code, 0);
  ASSERT_EQ(RunCairn({"init", dir_.File("map.gpkg")}).exit_code, 0);
  const Finished finished = RunCairn(
      {"ingest", dir_.File("map.gpkg"), "--model", dir_.File("colmap/sparse/0"), "--database",
       dir_.File("colmap/database.db"), "--georef", dir_.File("colmap/georef.csv")});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_THAT(finished.out, HasSubstr("residual 0.000 m median"));
}

TEST_F(Simulate, WritesASequenceAndAPlan) {
  const Finished finished =
      Run({"--sequence", dir_.File("walk"), "--duration", "2", "--picture", dir_.File("plan.png")});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_THAT(finished.out, HasSubstr("401 inertial samples, 21 frames"));
  EXPECT_TRUE(std::filesystem::exists(dir_.File("walk/mav0/imu0/data.csv")));
  const std::vector<uint8_t> png = ReadFileBytes(dir_.File("plan.png"), kMaxBytes);
  EXPECT_EQ(std::string(png.begin() + 1, png.begin() + 4), "PNG");
}

TEST_F(Simulate, RefusesWhatCannotBe) {
  const int usage = static_cast<int>(ExitCode::kUsage);
  const auto refusal_of = [&](const std::vector<std::string>& arguments) {
    const Finished finished = Run(arguments);
    EXPECT_EQ(finished.exit_code, usage);
    return finished.err;
  };
  EXPECT_THAT(refusal_of({}), HasSubstr("no output requested"));
  const std::string map = dir_.File("map.gpkg");
  EXPECT_THAT(refusal_of({"--map", map, "--area", "0"}), HasSubstr("city.area_km2 = 0"));
  EXPECT_THAT(refusal_of({"--map", map, "--area", "1e6"}), HasSubstr("nearest possible value"));
  EXPECT_THAT(refusal_of({"--map", map, "--gps-noise", "-3"}), HasSubstr("--gps-noise"));
  EXPECT_THAT(refusal_of({"--colmap", dir_.File("c"), "--area", "100"}),
              HasSubstr("the largest possible value is"));
  EXPECT_THAT(refusal_of({"--map", map, "--character", "village"}), HasSubstr("old-town, grid"));
  EXPECT_FALSE(std::filesystem::exists(map));
}

TEST_F(Simulate, NumbersThatAreNoneAreUsage) {
  for (const char* option : {"--area", "--relief", "--duration", "--frame-rate"}) {
    const Finished refused = Run({"--sequence", dir_.File("s"), option, "nan"});
    EXPECT_EQ(refused.exit_code, 2) << option;
    EXPECT_THAT(refused.err, HasSubstr(option));
  }
}

TEST_F(Simulate, PicturesOfUnknownFormatsAreRefusedBeforeTheWork) {
  const Finished refused = Run({"--map", dir_.File("m.gpkg"), "--picture", "x"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr(".png, .jpg"));
  EXPECT_FALSE(std::filesystem::exists(dir_.File("m.gpkg")));
}

TEST(CairnLab, EveryVerbHasHelpWithAnExample) {
  for (const char* verb : {"simulate", "experiment", "bench"}) {
    const Finished finished = RunCairnLab({verb, "--help"});
    EXPECT_EQ(finished.exit_code, 0) << verb;
    EXPECT_THAT(finished.out, HasSubstr(std::string(":\n  cairn-lab ") + verb)) << verb;
    EXPECT_EQ(finished.err, "") << verb;
  }
}

}  // namespace
}  // namespace cairn::testing
