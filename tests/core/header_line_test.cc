#include "core/wire/header_line.h"

#include <gtest/gtest.h>

#include <string>

namespace cairn {
namespace {

TEST(HeaderLine, SplitsNameAndValue) {
  for (const char* line : {"Content-Length: 5", "content-length:5", "CONTENT-LENGTH:\t 5 \t"}) {
    const auto header = SplitHeaderLine(line);
    ASSERT_TRUE(header) << line;
    EXPECT_EQ(header->name, "content-length");
    EXPECT_EQ(header->value, "5");
  }
  EXPECT_EQ(SplitHeaderLine("A:")->value, "");
  EXPECT_EQ(SplitHeaderLine("A: b: c")->value, "b: c");
}

TEST(HeaderLine, RefusesWhatReadersUnderstandInDifferentWays) {
  for (const std::string& line :
       {std::string(""), std::string("A"), std::string(": b"), std::string("A : b"),
        std::string(" A: b"), std::string("A\t: b"), std::string("A: \0", 4),
        std::string("A: b\rC: d"), std::string("A: b\nC: d"), std::string("A: \x7f")}) {
    EXPECT_FALSE(SplitHeaderLine(line)) << line;
  }
}

}  // namespace
}  // namespace cairn
