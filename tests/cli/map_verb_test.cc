// Tests `cairn map`: what it refuses, and that nothing is left of what it refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "cli/make_descriptor_file.h"
#include "cli/run_cairn.h"
#include "core/error.h"
#include "support/expect_error.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;

class MapVerb : public ::testing::Test {
 protected:
  // A picture of random squares, different for each seed.
  void AddPhoto(const std::string& name, uint64_t seed) const {
    constexpr int kSide = 160;
    std::mt19937_64 rng(seed);
    std::string pixels(kSide * kSide, '\x60');
    for (int i = 0; i < 200; ++i) {
      const int x = static_cast<int>(rng() % 150), y = static_cast<int>(rng() % 150);
      const char gray = static_cast<char>(rng() % 256);
      for (int v = 0; v < 10; ++v) {
        for (int u = 0; u < 10; ++u) {
          pixels[(y + v) * kSide + x + u] = gray;
        }
      }
    }
    std::filesystem::create_directories(dir_.path() / "photos");
    std::ofstream(dir_.path() / "photos" / name, std::ios::binary) << "P5\n160 160\n255\n"
                                                                   << pixels;
  }

  void AddPositions(const std::string& rows) const {
    std::ofstream(dir_.File("gps.csv")) << "image,lat_deg,lon_deg,h_m\n" << rows;
  }

  Finished Map(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"map", dir_.File("town.gpkg"), dir_.File("photos")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunCairn(arguments);
  }

  void ExpectRefused(const Finished& finished, const std::string& reason) const {
    EXPECT_NE(finished.exit_code, 0);
    EXPECT_THAT(finished.err, HasSubstr(reason));
    EXPECT_FALSE(std::filesystem::exists(dir_.File("town.gpkg")));
  }

  TempDir dir_;
};

TEST_F(MapVerb, NeedsThreePhotos) {
  AddPhoto("1.pgm", 1);
  AddPhoto("2.pgm", 2);
  ExpectRefused(Map(), "2 of 2 photos can be read, and a map needs 3");
}

TEST_F(MapVerb, NeedsPositions) {
  for (int i = 1; i <= 3; ++i) {
    AddPhoto(std::to_string(i) + ".pgm", i);
  }
  ExpectRefused(Map(), "0 of 3 photos have a position in their EXIF");
}

TEST_F(MapVerb, RefusesOnePositionForAll) {
  for (int i = 1; i <= 3; ++i) {
    AddPhoto(std::to_string(i) + ".pgm", i);
  }
  AddPositions("1.pgm,49,8,100\n2.pgm,49,8,100\n3.pgm,49,8,100\n");
  ExpectRefused(Map({"--gps", dir_.File("gps.csv")}), "same");
}

TEST_F(MapVerb, RefusesATableOfOtherPhotos) {
  for (int i = 1; i <= 3; ++i) {
    AddPhoto(std::to_string(i) + ".pgm", i);
  }
  AddPositions("a.jpg,49,8,100\nb.jpg,49.1,8,100\nc.jpg,49,8.1,100\n");
  ExpectRefused(Map({"--gps", dir_.File("gps.csv")}), "none of its names");
}

TEST_F(MapVerb, RefusesTwoPositionsOfOnePhoto) {
  for (int i = 1; i <= 3; ++i) {
    AddPhoto(std::to_string(i) + ".pgm", i);
  }
  AddPositions("1.pgm,49,8,100\n2.pgm,49.1,8,100\n3.pgm,49,8.1,100\n2.pgm,49.2,8,100\n");
  ExpectRefused(Map({"--gps", dir_.File("gps.csv")}), "2.pgm");
}

TEST_F(MapVerb, CountsNoPositionAtZero) {
  for (int i = 1; i <= 3; ++i) {
    AddPhoto(std::to_string(i) + ".pgm", i);
  }
  AddPositions("1.pgm,49.00012,8.00013,100\n2.pgm,49.10017,8.00011,100\n3.pgm,0,0,100\n");
  ExpectRefused(Map({"--gps", dir_.File("gps.csv")}), "2 of 3 photos have a position");
}

TEST_F(MapVerb, SaysWhenPhotosShowNothingInCommon) {
  for (int i = 1; i <= 4; ++i) {
    AddPhoto(std::to_string(i) + ".pgm", i);
  }
  AddPositions(
      "1.pgm,49,8,100\n2.pgm,49.0001,8,100\n3.pgm,49,8.0001,100\n4.pgm,49.0001,8.0001,1\n");
  ExpectRefused(Map({"--gps", dir_.File("gps.csv"), "--work", dir_.File("w")}),
                "no three of the 4 photos show the same place");
}

TEST_F(MapVerb, RefusesAMapInAFolderThatIsNotThere) {
  AddPhoto("1.pgm", 1);
  const Finished finished = RunCairn({"map", dir_.File("none/town.gpkg"), dir_.File("photos")});
  EXPECT_NE(finished.exit_code, 0);
  EXPECT_THAT(finished.err, HasSubstr("the map cannot be made in"));
}

TEST_F(MapVerb, RefusesATimeBeforeItReadsPhotos) {
  ExpectRefused(Map({"--recorded", "monday"}), "2026-01-31T12:00:00Z");
}

TEST_F(MapVerb, TakesTheDefaultByName) {
  ExpectRefused(Map({"--join"}), "there is no such folder");
  const Finished both = Map({"--join", "--apart"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_THAT(both.err, HasSubstr("--apart"));
}

TEST_F(MapVerb, MakesTheArchiveButNotTheFolderAboveIt) {
  AddPhoto("1.pgm", 1);
  ExpectRefused(Map({"--archive", dir_.File("none/archive")}), "the folder above this one");
  ExpectRefused(Map({"--archive", dir_.File("archive")}), "1 of 1 photos can be read");
  EXPECT_TRUE(std::filesystem::is_directory(dir_.File("archive")));
}

TEST_F(MapVerb, NamesAFolderForScratchFilesThatIsNotThere) {
  const char* before = std::getenv("TMPDIR");
  const std::string folder = before == nullptr ? "" : before;
  setenv("TMPDIR", dir_.File("none").c_str(), 1);
  ExpectError([] { MakeDescriptorFile(); }, ErrorCode::kIo,
              "none: a scratch file cannot be made: No such file or directory. Name another folder "
              "in the environment variable TMPDIR");
  for (const std::string& usable : {dir_.File(""), std::string()}) {
    setenv("TMPDIR", usable.c_str(), 1);
    EXPECT_NE(MakeDescriptorFile(), nullptr);
  }
  before == nullptr ? unsetenv("TMPDIR") : setenv("TMPDIR", folder.c_str(), 1);
}

TEST_F(MapVerb, RefusesAFolderThatIsNotThere) { ExpectRefused(Map(), "there is no such folder"); }

}  // namespace
}  // namespace cairn::testing
