#include "mapping/work_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

const std::vector<uint8_t> kBytes = {1, 2, 3, 4, 5};

TEST(WorkFolder, KeepsBytesForTheirKey) {
  const testing::TempDir dir;
  {
    const WorkFolder folder(dir.path() / "w");
    folder.Store("views-00000", "key", kBytes);
  }
  const WorkFolder folder(dir.path() / "w");
  EXPECT_EQ(folder.Load("views-00000", "key"), kBytes);
  EXPECT_FALSE(folder.Load("views-00000", "another key"));
  EXPECT_FALSE(folder.Load("segments", "key"));
}

TEST(WorkFolder, ReplacesBytes) {
  const testing::TempDir dir;
  const WorkFolder folder(dir.path());
  folder.Store("views-00000", "one", kBytes);
  folder.Store("views-00000", "two", {});
  EXPECT_FALSE(folder.Load("views-00000", "one"));
  EXPECT_EQ(folder.Load("views-00000", "two"), std::vector<uint8_t>());
}

TEST(WorkFolder, DoesNotTrustDamagedFiles) {
  const testing::TempDir dir;
  const WorkFolder folder(dir.path());
  folder.Store("views-00000", "key", kBytes);
  const auto size = std::filesystem::file_size(folder.PathOf("views-00000"));
  for (const auto at : {uintmax_t{0}, uintmax_t{9}, uintmax_t{17}, size - 1}) {
    folder.Store("views-00000", "key", kBytes);
    std::fstream file(folder.PathOf("views-00000"),
                      std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(at));
    file.put('\xff');
    file.close();
    EXPECT_FALSE(folder.Load("views-00000", "key")) << at;
  }
  for (uintmax_t cut = 0; cut < size; ++cut) {
    folder.Store("views-00000", "key", kBytes);
    std::filesystem::resize_file(folder.PathOf("views-00000"), cut);
    EXPECT_FALSE(folder.Load("views-00000", "key")) << cut;
  }
}

TEST(WorkFolder, IsForOneRunAtATime) {
  const testing::TempDir dir;
  const WorkFolder folder(dir.path());
  try {
    const WorkFolder again(dir.path());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kConflict);
  }
}

TEST(WorkFolder, RemovesWhatAKilledRunLeft) {
  for (const std::string name :
       {"photo-0123456789abcdef", "focal-00000", "cameras", "views-00000", "corrected",
        "again-00000", "grown-0", "regrown-1-00000", "segments", "report.svg", "report.png"}) {
    const testing::TempDir dir;
    const auto left = dir.path() / (name + ".0123.part");
    std::ofstream(left) << "half";
    const WorkFolder folder(dir.path());
    EXPECT_FALSE(std::filesystem::exists(left)) << name;
    folder.Store(name, "key", kBytes);
    EXPECT_EQ(folder.Load(name, "key"), kBytes) << name;
  }
}

TEST(WorkFolder, StoresNothingThatTheNextRunWouldNotRemove) {
  const testing::TempDir dir;
  const WorkFolder folder(dir.path());
  EXPECT_DEATH(folder.Store("holiday", "key", kBytes), "unfinished file");
}

TEST(WorkFolder, KeepsUnfinishedFilesOfOthers) {
  const testing::TempDir dir;
  const auto download = dir.path() / "holiday.zip.part";
  std::ofstream(download) << "half";
  const WorkFolder folder(dir.path());
  EXPECT_TRUE(std::filesystem::exists(download));
}

}  // namespace
}  // namespace cairn
