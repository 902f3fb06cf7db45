#include "core/file_bytes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/error.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

TEST(WriteFileBytes, ReplacesWhatThePathHad) {
  const testing::TempDir dir;
  const std::vector<uint8_t> bytes = {0, 255, 13, 10, 0};
  WriteTextFile(dir.File("a"), "a longer text");
  WriteFileBytes(dir.File("a"), bytes);
  EXPECT_EQ(ReadFileBytes(dir.File("a"), 100), bytes);
}

std::string RefusalOf(const std::string& text) {
  const testing::TempDir dir;
  WriteTextFile(dir.File("a"), text);
  try {
    ReadTextFile(dir.File("a"), 1000);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    return error.what();
  }
  return "no error";
}

TEST(ReadTextFile, TellsUtf16FromBinaryFiles) {
  using std::string_literals::operator""s;
  for (const std::string& text : {"i\0m\0"s, "\0i\0m"s, "\xff\xfei\0"s, "\xfe\xff\0i"s}) {
    EXPECT_THAT(RefusalOf(text), HasSubstr("the text is UTF-16"));
  }
  for (const std::string& bytes : {"\x1d\0\0\0\0\0\0\0"s, "\xff\xd8\xff\xe0\0\x10"s,
                                   "SQLite format 3\0"s, "\xff\xfe\0\0i\0\0\0"s}) {
    EXPECT_THAT(RefusalOf(bytes), HasSubstr("this is not a text file"));
  }
  EXPECT_THAT(RefusalOf("PK\3\4\x14\0"s), HasSubstr("save a spreadsheet as CSV"));
  EXPECT_EQ(RefusalOf("image,lat\n"), "no error");
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
