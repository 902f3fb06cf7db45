#include "core/file_bytes.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "core/error.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

TEST(WriteFileBytes, ReplacesWhatThePathHad) {
  const testing::TempDir dir;
  const std::vector<uint8_t> bytes = {0, 255, 13, 10, 0};
  WriteTextFile(dir.File("a"), "a longer text");
  WriteFileBytes(dir.File("a"), bytes);
  EXPECT_EQ(ReadFileBytes(dir.File("a"), 100), bytes);
}

TEST(WriteTextFile, NamesTheFileThatItCannotWrite) {
  const testing::TempDir dir;
  try {
    WriteTextFile(dir.File("no_folder/a"), "text");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kIo);
    EXPECT_EQ(error.what(), dir.File("no_folder/a") + ": cannot write");
  }
  EXPECT_THROW(WriteTextFile("/dev/full", "text"), Error);
}

}  // namespace
}  // namespace cairn
