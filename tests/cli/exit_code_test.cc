// Tests every kind of failure: its exit code, a message on stderr that names the cause, and an
// empty stdout.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "cli/run_cairn.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

void ExpectFailure(const Finished& finished, int exit_code, const std::string& message_part) {
  EXPECT_EQ(finished.exit_code, exit_code) << finished.err;
  EXPECT_THAT(finished.out, IsEmpty());
  EXPECT_THAT(finished.err, StartsWith("cairn: "));
  EXPECT_THAT(finished.err, HasSubstr(message_part));
}

class ExitCode : public ::testing::Test {
 protected:
  std::string EmptyMap() const {
    const std::string path = dir_.File("map.gpkg");
    EXPECT_EQ(RunCairn({"init", path}).exit_code, 0);
    return path;
  }

  // A gray 64 x 48 photo of nothing.
  std::string Photo() const {
    const std::string path = dir_.File("photo.pgm");
    std::ofstream(path, std::ios::binary) << "P5\n64 48\n255\n" << std::string(64 * 48, '\x80');
    return path;
  }

  std::string WriteFile(const std::string& name, const std::string& text) const {
    const std::string path = dir_.File(name);
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }

  TempDir dir_;
};

TEST_F(ExitCode, WithoutAVerbIsUsage) { ExpectFailure(RunCairn({}), 2, "subcommand"); }

TEST_F(ExitCode, UnknownVerbIsUsage) { ExpectFailure(RunCairn({"fly", "map.gpkg"}), 2, "fly"); }

TEST_F(ExitCode, MissingArgumentIsUsage) { ExpectFailure(RunCairn({"init"}), 2, "MAP"); }

TEST_F(ExitCode, UnknownOptionIsUsage) {
  ExpectFailure(RunCairn({"info", "map.gpkg", "--color"}), 2, "--color");
}

TEST_F(ExitCode, UsageErrorsPointToTheVerbsHelp) {
  ExpectFailure(RunCairn({"serve"}), 2, "cairn serve --help");
}

TEST_F(ExitCode, InitRefusesAnExistingFile) {
  ExpectFailure(RunCairn({"init", EmptyMap()}), 4, "map.gpkg");
}

TEST_F(ExitCode, InitWhereNothingCanBeWrittenIsIo) {
  ExpectFailure(RunCairn({"init", dir_.File("no/such/folder/map.gpkg")}), 6, "map.gpkg");
}

TEST_F(ExitCode, EveryReaderOfAMissingMapNamesIt) {
  const std::string path = dir_.File("missing.gpkg");
  ExpectFailure(RunCairn({"info", path}), 4, "missing.gpkg");
  ExpectFailure(RunCairn({"check", path}), 4, "missing.gpkg");
  ExpectFailure(RunCairn({"sql", path, "SELECT 1"}), 4, "missing.gpkg");
  ExpectFailure(RunCairn({"serve", path, "--port", "0"}), 4, "missing.gpkg");
  ExpectFailure(RunCairn({"remove", path, "monday"}), 4, "missing.gpkg");
  ExpectFailure(
      RunCairn({"localize", path, "--image", Photo(), "--camera", "SIMPLE_PINHOLE,64,48,50,32,24"}),
      4, "missing.gpkg");
}

TEST_F(ExitCode, ForeignFileIsBadInput) {
  ExpectFailure(RunCairn({"info", WriteFile("notes.gpkg", "These are my notes on the city.\n")}), 4,
                "notes.gpkg");
}

TEST_F(ExitCode, EmptyFileIsBadInput) {
  ExpectFailure(RunCairn({"info", WriteFile("empty.gpkg", "")}), 4, "empty.gpkg");
}

TEST_F(ExitCode, TruncatedMapIsDamaged) {
  const std::string path = EmptyMap();
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  ExpectFailure(RunCairn({"check", path}), 5, "map.gpkg");
}

TEST_F(ExitCode, RemovingAnUnknownSessionNamesIt) {
  ExpectFailure(RunCairn({"remove", EmptyMap(), "monday"}), 4, "monday");
}

TEST_F(ExitCode, IngestWithoutPositionsIsUsage) {
  ExpectFailure(RunCairn({"ingest", EmptyMap(), "--model", "m", "--database", "d"}), 2, "--georef");
}

TEST_F(ExitCode, IngestOfAMissingModelNamesIt) {
  ExpectFailure(RunCairn({"ingest", EmptyMap(), "--model", dir_.File("no_model"), "--database",
                          dir_.File("no.db"), "--gps"}),
                4, "no_");
}

TEST_F(ExitCode, PositionsAreEitherCsvOrGps) {
  ExpectFailure(RunCairn({"ingest", EmptyMap(), "--model", "m", "--database", "d", "--gps",
                          "--georef", "g.csv"}),
                2, "--gps");
}

TEST_F(ExitCode, EmptyMapDoesNotLocalize) {
  const Finished finished =
      RunCairn({"localize", EmptyMap(), "--image", Photo(), "--camera",
                "SIMPLE_PINHOLE,64,48,50,32,24", "--prior", "47.3769,8.5417,408"});
  EXPECT_EQ(finished.exit_code, 3) << finished.err;
  EXPECT_THAT(finished.out, StartsWith("not localized: "));
}

TEST_F(ExitCode, UnknownCameraModelIsUsageAndNamesTheModels) {
  ExpectFailure(
      RunCairn({"localize", EmptyMap(), "--image", Photo(), "--camera", "MAGIC,64,48,50,32,24"}), 2,
      "SIMPLE_PINHOLE");
}

TEST_F(ExitCode, WrongNumberOfCameraParametersIsUsage) {
  ExpectFailure(
      RunCairn({"localize", EmptyMap(), "--image", Photo(), "--camera", "PINHOLE,64,48,50"}), 2,
      "--camera");
}

TEST_F(ExitCode, CameraOfAnotherSizeThanThePhotoIsBadInput) {
  ExpectFailure(RunCairn({"localize", EmptyMap(), "--image", Photo(), "--camera",
                          "SIMPLE_PINHOLE,640,480,500,320,240"}),
                4, "64 x 48");
}

TEST_F(ExitCode, NumbersThatAreNoneAreUsage) {
  const std::string map = EmptyMap();
  for (const char* prior : {"47", "47,8,nan", "47,8,inf", "91,8,0", "47,8,4o8", "", ",,"}) {
    const Finished finished = RunCairn({"localize", map, "--image", Photo(), "--camera",
                                        "SIMPLE_PINHOLE,64,48,50,32,24", "--prior", prior});
    ExpectFailure(finished, 2, "--prior");
  }
}

TEST_F(ExitCode, GravityWithoutDirectionIsUsage) {
  ExpectFailure(RunCairn({"localize", EmptyMap(), "--image", Photo(), "--camera",
                          "SIMPLE_PINHOLE,64,48,50,32,24", "--gravity", "0,0,0"}),
                2, "--gravity");
}

TEST_F(ExitCode, PhotoWithoutFocalLengthIsOfAnUnknownCamera) {
  const std::string map = EmptyMap();
  EXPECT_EQ(RunCairn({"localize", map, "--image", Photo()}).exit_code, 3);
  ExpectFailure(RunCairn({"localize", map, "--image", Photo(), "--rig", "rig.json"}), 2,
                "--camera");
}

TEST_F(ExitCode, FocalSigmaThatIsNoneIsUsage) {
  const std::string map = EmptyMap();
  for (const char* sigma : {"0", "-5", "80", "much"}) {
    ExpectFailure(RunCairn({"localize", map, "--image", Photo(), "--camera",
                            "SIMPLE_PINHOLE,64,48,50,32,24", "--focal-sigma", sigma}),
                  2, "--focal-sigma");
  }
}

TEST_F(ExitCode, PhotoThatDoesNotDecodeIsBadInput) {
  ExpectFailure(RunCairn({"localize", EmptyMap(), "--image", WriteFile("bad.jpg", "not a jpeg")}),
                4, "bad.jpg");
}

TEST_F(ExitCode, MapAndServerAtOnceIsUsage) {
  ExpectFailure(
      RunCairn({"localize", EmptyMap(), "--server", "http://127.0.0.1:1", "--image", Photo()}), 2,
      "--server");
}

TEST_F(ExitCode, ServerThatIsNotThereIsUnreachable) {
  ExpectFailure(RunCairn({"localize", "--server", "http://127.0.0.1:1", "--image", Photo(),
                          "--camera", "SIMPLE_PINHOLE,64,48,50,32,24"}),
                7, "127.0.0.1:1");
}

TEST_F(ExitCode, EvalWithoutQueriesIsUsage) {
  ExpectFailure(RunCairn({"eval", EmptyMap()}), 2, "--queries");
}

TEST_F(ExitCode, ReportOfQueriesOfElsewhereIsUsage) {
  const std::string map = EmptyMap();
  for (const char* option : {"--elsewhere", "--permute-descriptors"}) {
    ExpectFailure(RunCairn({"eval", map, "--queries", "q.json", option, "--report", "report"}), 2,
                  option);
  }
}

TEST_F(ExitCode, WritingSqlIsBadInput) {
  const std::string map = EmptyMap();
  ExpectFailure(RunCairn({"sql", map, "DELETE FROM cairn_sessions"}), 4, "");
  EXPECT_EQ(RunCairn({"check", map}).exit_code, 0);
}

TEST_F(ExitCode, SqlThatDoesNotParseIsBadInputWithTheReason) {
  ExpectFailure(RunCairn({"sql", EmptyMap(), "SELEC 1"}), 4, "SELEC");
}

// SQLite cannot be interrupted within one function.
TEST_F(ExitCode, SqlThatComputesOneHugeValueEndsInTime) {
  const std::string sql =
      "SELECT instr(zeroblob(30000000), CAST(zeroblob(15000000) || x'01' AS BLOB))";
  ExpectFailure(RunCairn({"sql", EmptyMap(), sql, "--timeout", "0.01"}), 4, "the time is up");
}

TEST_F(ExitCode, FullStandardOutputIsIo) {
  if (!std::filesystem::exists("/dev/full")) {
    GTEST_SKIP() << "needs /dev/full";
  }
  const std::string command =
      std::string(CAIRN_BINARY) + " info " + EmptyMap() + " > /dev/full 2> /dev/null";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 6);
}

}  // namespace
}  // namespace cairn::testing
