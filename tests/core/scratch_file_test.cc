#include "core/scratch_file.h"

#include <gtest/gtest.h>
#include <linux/magic.h>
#include <sys/vfs.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/parallel_for.h"
#include "support/file_size_limit.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

std::vector<uint8_t> BytesOf(uint8_t value, size_t count) {
  return std::vector<uint8_t>(count, value);
}

TEST(ScratchFile, GivesBackWhatSeveralThreadsAppended) {
  const testing::TempDir dir;
  ScratchFile file(dir.path());
  std::vector<uint64_t> positions(50);
  ParallelFor(50, 4, [&](int i) {
    positions[i] = file.Append(BytesOf(static_cast<uint8_t>(i), 1000 + i));
  });
  for (int i = 0; i < 50; ++i) {
    std::vector<uint8_t> bytes(1000 + i);
    file.Read(positions[i], bytes);
    EXPECT_EQ(bytes, BytesOf(static_cast<uint8_t>(i), 1000 + i));
  }
}

TEST(ScratchFile, HasNoName) {
  const testing::TempDir dir;
  ScratchFile file(dir.path());
  file.Append(BytesOf(1, 10));
  EXPECT_TRUE(std::filesystem::is_empty(dir.path()));
}

TEST(ScratchFile, KnowsFoldersThatLieInMemory) {
  struct statfs info = {};
  if (statfs("/dev/shm", &info) != 0 || info.f_type != TMPFS_MAGIC) {
    GTEST_SKIP() << "/dev/shm is no file system in memory";
  }
  EXPECT_FALSE(ScratchFile("/dev/shm").is_on_disk());
}

TEST(ScratchFile, NamesTheFolderInErrors) {
  const testing::TempDir dir;
  const auto expect_error = [](const std::string& folder, const std::string& text,
                               const auto& act) {
    try {
      act();
      FAIL() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kIo);
      EXPECT_TRUE(std::string(error.what()).starts_with(folder + ": ")) << error.what();
      EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
    }
  };
  expect_error(dir.File("none"), "cannot be made", [&] { ScratchFile(dir.File("none")); });
  ScratchFile file(dir.path());
  std::vector<uint8_t> bytes(10);
  expect_error(dir.path(), "cannot be read", [&] { file.Read(0, bytes); });
  const testing::FileSizeLimit limit(1000);
  file.Append(BytesOf(1, 900));
  expect_error(dir.path(), "cannot be written", [&] { file.Append(BytesOf(1, 900)); });
}

}  // namespace
}  // namespace cairn
