// Tests input that is meant to hang, flood or deceive the program, and common typing errors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "cli/run_cairn.h"
#include "storage/map/map_store.h"
#include "support/map_builder.h"
#include "support/raw_sql.h"
#include "support/street_map.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

constexpr const char* kEscape = "\x1b[2J";

class HostileInput : public ::testing::Test {
 protected:
  std::string Map() const {
    const std::string path = dir_.File("map.gpkg");
    return std::filesystem::exists(path) ? path : MakeStreetMap(path);
  }

  std::string WriteFile(const std::string& name, const std::string& text) const {
    const std::string path = dir_.File(name);
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }

  std::string Photo() const {
    return WriteFile("photo.pgm", "P5\n64 48\n255\n" + std::string(64 * 48, '\x80'));
  }

  static void ExpectRefused(const std::vector<std::string>& arguments, int exit_code,
                            const std::string& message_part) {
    const Finished finished = RunCairn(arguments);
    EXPECT_EQ(finished.exit_code, exit_code) << finished.err;
    EXPECT_THAT(finished.out, IsEmpty());
    EXPECT_THAT(finished.err, AllOf(StartsWith("cairn: "), HasSubstr(message_part)));
    EXPECT_LT(finished.err.size(), 2000u);
    EXPECT_THAT(finished.err, Not(HasSubstr("\x1b")));
  }

  TempDir dir_;
};

TEST_F(HostileInput, SeedsThatAreNoneAreUsage) {
  const std::string map = Map();
  for (const char* seed : {"-1", "nan", "1e3", "99999999999999999999999"}) {
    ExpectRefused({"localize", map, "--image", Photo(), "--seed", seed}, 2, "--seed");
    ExpectRefused({"eval", map, "--queries", "q.json", "--seed", seed}, 2, "--seed");
  }
}

TEST_F(HostileInput, AccuraciesThatAreNoneAreUsage) {
  const std::string map = Map();
  for (const char* accuracy : {"nan", "inf", "-5", "0", "ten"}) {
    ExpectRefused(
        {"localize", map, "--image", Photo(), "--prior", "47,8,400", "--accuracy", accuracy}, 2,
        "--accuracy");
    ExpectRefused(
        {"ingest", map, "--model", "m", "--database", "d", "--gps", "--gps-accuracy", accuracy}, 2,
        "--gps-accuracy");
  }
}

TEST_F(HostileInput, NoiseThatIsNoNumberIsUsage) {
  const std::string map = Map();
  for (const char* option : {"--prior-noise", "--gravity-noise-deg", "--min-score"}) {
    ExpectRefused({"eval", map, "--queries", "q.json", option, "nan"}, 2, option);
  }
}

TEST_F(HostileInput, ThreadsThatTheServerDoesNotHaveAreUsage) {
  ExpectRefused({"serve", Map(), "--threads", "2000"}, 2, "--threads");
}

TEST_F(HostileInput, UnknownGlobalOptionsAreNamed) {
  ExpectRefused({"--nope"}, 2, "there is no option '--nope'");
  ExpectRefused({"--log-level", "off", "--nope=3"}, 2, "there is no option '--nope'");
  ExpectRefused({"--nope"}, 2, "cairn --help");
  ExpectRefused({"--log-level", "off", "fly"}, 2, "there is no verb 'fly'");
}

TEST_F(HostileInput, ADirectoryIsNamedAsOne) {
  ExpectRefused({"localize", Map(), "--image", dir_.path().string()}, 4, "is a directory");
}

TEST_F(HostileInput, PicturesOfUnknownFormatsAreRefusedBeforeTheWork) {
  // The photo does not exist: nobody looked for it.
  ExpectRefused({"localize", Map(), "--image", "none.jpg", "--picture", "x.foo"}, 2, ".png, .jpg");
}

TEST_F(HostileInput, EndlessFilesAreReadToALimit) {
  ExpectRefused(
      {"ingest", Map(), "--model", "m", "--database", "d", "--gps", "--images", "/dev/zero"}, 4,
      "/dev/zero: the file is larger than the limit");
  ExpectRefused({"eval", Map(), "--queries", "/dev/zero"}, 4,
                "/dev/zero: the file is larger than the limit");
  ExpectRefused({"extract", Map(), "--geojson", "/dev/zero", "--out", dir_.File("part.gpkg")}, 4,
                "/dev/zero: the file is larger than the limit");
  ExpectRefused({"localize", Map(), "--image", "/dev/zero"}, 4,
                "/dev/zero: the file is larger than the limit");
}

TEST_F(HostileInput, NamesOfMegabytesAreNotEchoed) {
  const std::string name(2'000'000, 'a');
  const std::string list = WriteFile(
      "q.json", R"({"format": "cairn query list", "version": 1, "queries": [{"name": "x",)"
                R"("features": "f", "camera": {"model": ")" +
                    name + R"(", "size": [64, 48], "modelParams": [1]}}]})");
  ExpectRefused({"eval", Map(), "--queries", list}, 4, "camera model 'aaa");
  ExpectRefused({"sql", Map(), "SELECT " + std::string(100'000, 'a')}, 4, "SQL: ");
  ExpectRefused({"remove", Map(), std::string(100'000, 'a')}, 4, "has no session 'aaa");
}

TEST_F(HostileInput, EscapeSequencesDoNotReachTheTerminal) {
  const std::string map = Map();
  ExecuteRaw(map,
             "UPDATE cairn_sessions SET name = 'a' || char(27) || '[2J' || char(155) || '2J' "
             "WHERE session_id = 1");
  for (const char* command : {"info", "check"}) {
    const Finished finished = RunCairn({command, map});
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    EXPECT_THAT(finished.out + finished.err, Not(HasSubstr("\x1b")));
  }
  for (const char* format : {"table", "json"}) {
    const Finished finished =
        RunCairn({"sql", map, "SELECT name AS \"a\x1b\" FROM cairn_sessions", "--format", format});
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    EXPECT_THAT(finished.out, AllOf(Not(HasSubstr("\x1b")), Not(HasSubstr("\u009b"))));
  }
  const Finished json = RunCairn({"info", map, "--json"});
  EXPECT_THAT(json.out, AllOf(Not(HasSubstr("\x1b")), Not(HasSubstr("\u009b"))));
  ExpectRefused({"remove", map, kEscape}, 4, "\\x1b[2J");
  ExpectRefused({"info", dir_.File(std::string("no") + kEscape)}, 4, "\\x1b[2J");
  ExpectRefused({kEscape}, 2, "\\x1b[2J");
}

TEST_F(HostileInput, CheckExitsWithDamageAndSaysWhat) {
  const std::string map = Map();
  ExecuteRaw(map, "UPDATE cairn_keyframe_poses SET qw = 0, qx = 0, qy = 0, qz = 0");
  const Finished finished = RunCairn({"check", map});
  EXPECT_EQ(finished.exit_code, 5);
  EXPECT_THAT(finished.out, HasSubstr("keyframe 1: "));
}

TEST_F(HostileInput, OutputThatCannotBeWrittenIsSaid) {
  if (!std::filesystem::exists("/dev/full")) {
    GTEST_SKIP() << "needs /dev/full";
  }
  const std::string many =
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 100000) "
      "SELECT i FROM n";
  const std::string map = Map();
  for (const std::string& arguments :
       {"info " + map, "info " + map + " --json", std::string("--help"), std::string("info --help"),
        std::string("--version"), "check " + map, "sql " + map + " '" + many + "'",
        "sql " + map + " --format json '" + many + "'", "serve " + map + " --port 0"}) {
    const std::string err = dir_.File("err");
    const std::string command =
        std::string(CAIRN_BINARY) + " " + arguments + " > /dev/full 2> " + err;
    EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 6) << arguments;
    std::ifstream file(err);
    const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    EXPECT_THAT(text, HasSubstr("cairn: ")) << arguments;
  }
}

TEST_F(HostileInput, SqlStopsWhenItsTimeIsUp) {
  ExpectRefused(
      {"sql", Map(), "--timeout", "0.2",
       "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT max(i) FROM n"},
      4, "--timeout");
  ExpectRefused({"sql", Map(), "--timeout", "nan", "SELECT 1"}, 2, "--timeout");
}

// A killed init leaves a file under another name, which the next init takes over.
TEST_F(HostileInput, AnInterruptedInitDoesNotBlockTheNext) {
  const std::string map = dir_.File("new.gpkg");
  WriteFile("new.gpkg.unfinished", "half a map");
  WriteFile("new.gpkg.unfinished-wal", "half a log");
  EXPECT_EQ(RunCairn({"init", map}).exit_code, 0);
  EXPECT_EQ(RunCairn({"check", map}).exit_code, 0);
  std::vector<std::string> unfinished;
  for (const auto& entry : std::filesystem::directory_iterator(dir_.path())) {
    const std::string name = entry.path().filename().string();
    if (name.find("unfinished") != std::string::npos) {
      unfinished.push_back(name);
    }
  }
  EXPECT_THAT(unfinished, ::testing::IsEmpty());
  ExpectRefused({"init", map}, 4, "already exists");
}

// A map is whole, or it is not there: on disks that are full at every stage of its making.
TEST_F(HostileInput, AFullDiskLeavesNoHalfMap) {
  const std::string script = WriteFile("fill.sh", R"sh(set -e
mount -t tmpfs -o size="$1k" tmpfs "$2"
code=0
"$3" init "$2/a.gpkg" 2> "$4" || code=$?
if [ "$code" -eq 0 ]; then "$3" check "$2/a.gpkg" > /dev/null; exit; fi
[ "$code" -eq 6 ] && [ -z "$(ls "$2")" ] && grep -q full "$4"
)sh");
  std::filesystem::create_directory(dir_.path() / "disk");
  const auto in_namespace = [](const std::string& command) {
    return WEXITSTATUS(std::system(("unshare --map-root-user --mount " + command).c_str()));
  };
  if (in_namespace("mount -t tmpfs tmpfs '" + dir_.File("disk") + "' 2> /dev/null") != 0) {
    GTEST_SKIP() << "needs a user namespace";
  }
  for (const int disk_kb : {100, 300, 500, 600, 700, 800, 900, 1000, 1100, 1300}) {
    EXPECT_EQ(in_namespace("sh " + script + " " + std::to_string(disk_kb) + " " +
                           dir_.File("disk") + " " CAIRN_BINARY " " + dir_.File("err")),
              0)
        << disk_kb << " kB";
  }
}

}  // namespace
}  // namespace cairn::testing
