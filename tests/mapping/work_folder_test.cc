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
    folder.Store("pairs", "key", kBytes);
  }
  const WorkFolder folder(dir.path() / "w");
  EXPECT_EQ(folder.Load("pairs", "key"), kBytes);
  EXPECT_FALSE(folder.Load("pairs", "another key"));
  EXPECT_FALSE(folder.Load("segments", "key"));
}

TEST(WorkFolder, ReplacesBytes) {
  const testing::TempDir dir;
  const WorkFolder folder(dir.path());
  folder.Store("pairs", "one", kBytes);
  folder.Store("pairs", "two", {});
  EXPECT_FALSE(folder.Load("pairs", "one"));
  EXPECT_EQ(folder.Load("pairs", "two"), std::vector<uint8_t>());
}

TEST(WorkFolder, DoesNotTrustDamagedFiles) {
  const testing::TempDir dir;
  const WorkFolder folder(dir.path());
  folder.Store("pairs", "key", kBytes);
  const auto size = std::filesystem::file_size(folder.PathOf("pairs"));
  for (const auto at : {uintmax_t{0}, uintmax_t{9}, uintmax_t{17}, size - 1}) {
    folder.Store("pairs", "key", kBytes);
    std::fstream file(folder.PathOf("pairs"), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(at));
    file.put('\xff');
    file.close();
    EXPECT_FALSE(folder.Load("pairs", "key")) << at;
  }
  for (uintmax_t cut = 0; cut < size; ++cut) {
    folder.Store("pairs", "key", kBytes);
    std::filesystem::resize_file(folder.PathOf("pairs"), cut);
    EXPECT_FALSE(folder.Load("pairs", "key")) << cut;
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
  const testing::TempDir dir;
  const auto left = dir.path() / "views-00000.0123.part";
  std::ofstream(left) << "half";
  const WorkFolder folder(dir.path());
  EXPECT_FALSE(std::filesystem::exists(left));
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
