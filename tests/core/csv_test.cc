#include "core/csv.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cairn {
namespace {

TEST(CsvText, IsQuotedOnlyWhereItHasTo) {
  EXPECT_EQ(CsvText(""), "");
  EXPECT_EQ(CsvText("a b;'c"), "a b;'c");
  EXPECT_EQ(CsvText("a,b"), "\"a,b\"");
  EXPECT_EQ(CsvText("say \"b\""), "\"say \"\"b\"\"\"");
  EXPECT_EQ(CsvText("a\nb"), "\"a\nb\"");
  EXPECT_EQ(CsvText("a\rb"), "\"a\rb\"");
}

TEST(CsvNumber, HasSixDigitsOrNone) {
  EXPECT_EQ(CsvNumber(-1234.5678), "-1234.57");
  EXPECT_EQ(CsvNumber(0.0), "0");
  EXPECT_EQ(CsvNumber(std::nan("")), "");
  EXPECT_EQ(CsvNumber(-INFINITY), "");
}

}  // namespace
}  // namespace cairn
