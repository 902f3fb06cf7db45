#include "core/csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/error.h"

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

using Records = std::vector<std::vector<std::string>>;

Records RecordsOf(std::string_view text) {
  CsvReader reader(text);
  Records records;
  while (reader.Next()) {
    records.push_back(reader.cells());
  }
  return records;
}

std::string ErrorOf(std::string_view text) {
  try {
    RecordsOf(text);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    return error.what();
  }
  return "no error";
}

TEST(CsvReader, SplitsAndTrimsPlainCells) {
  EXPECT_EQ(RecordsOf("a,b\n c , d e \n"), (Records{{"a", "b"}, {"c", "d e"}}));
  EXPECT_EQ(RecordsOf("a,,\n,"), (Records{{"a", "", ""}, {"", ""}}));
}

TEST(CsvReader, QuotedCellsHoldEverything) {
  EXPECT_EQ(RecordsOf("\"a,b\", \"say \"\"c\"\"\" ,\"\"\n\"d\r\ne\",f,g"),
            (Records{{"a,b", "say \"c\"", ""}, {"d\r\ne", "f", "g"}}));
  EXPECT_EQ(RecordsOf("\" a \",5\" pipe"), (Records{{" a ", "5\" pipe"}}));
}

TEST(CsvReader, WhatCsvTextWritesComesBack) {
  const std::vector<std::string> cells = {"a,b", "\"", "c\nd", "e"};
  std::string line;
  for (const std::string& cell : cells) {
    line += (line.empty() ? "" : ",") + CsvText(cell);
  }
  EXPECT_EQ(RecordsOf(line), Records{cells});
}

TEST(CsvReader, EveryEndOfLineIsOne) {
  EXPECT_EQ(RecordsOf("a\r\n\r\nb\rc\n \n\td"), (Records{{"a"}, {"b"}, {"c"}, {"d"}}));
  EXPECT_EQ(RecordsOf("\n\n"), Records{});
  EXPECT_EQ(RecordsOf(""), Records{});
}

TEST(CsvReader, FindsTheSeparatorInTheFirstLine) {
  EXPECT_EQ(RecordsOf("\r\n\"a,b\";c\n1,5;2"), (Records{{"a,b", "c"}, {"1,5", "2"}}));
  EXPECT_EQ(RecordsOf("a\tb\n\t2"), (Records{{"a", "b"}, {"", "2"}}));
  EXPECT_EQ(RecordsOf("a;x,b\n1;2,3"), (Records{{"a;x", "b"}, {"1;2", "3"}}));
}

TEST(CsvReader, TheFirstLineMayNameTheSeparator) {
  EXPECT_EQ(RecordsOf("sep=;\r\na,b;c\n"), (Records{{"a,b", "c"}}));
  EXPECT_EQ(RecordsOf("sep=,\na,b\n"), (Records{{"a", "b"}}));
  EXPECT_EQ(RecordsOf("sep=x,y\n"), (Records{{"sep=x", "y"}}));
  CsvReader reader("sep=|\na|b\n");
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.line(), 2);
}

TEST(CsvReader, NumbersMayHaveAPlusAndADecimalComma) {
  CsvReader comma("1.5,+2,\"-3e2\",1.5m,");
  ASSERT_TRUE(comma.Next());
  EXPECT_EQ(comma.Number(0), 1.5);
  EXPECT_EQ(comma.Number(1), 2.0);
  EXPECT_EQ(comma.Number(2), -300.0);
  EXPECT_EQ(comma.Number(3), std::nullopt);
  EXPECT_EQ(comma.Number(4), std::nullopt);
  CsvReader semicolon("lat;lon\n55,698;1.5");
  semicolon.Next();
  ASSERT_TRUE(semicolon.Next());
  EXPECT_EQ(semicolon.Number(0), 55.698);
  EXPECT_EQ(semicolon.Number(1), 1.5);
}

TEST(CsvReader, ErrorsNameTheLine) {
  EXPECT_THAT(ErrorOf("a,b\n1,\"2\n3\n"), ::testing::HasSubstr("line 2"));
  EXPECT_THAT(ErrorOf("a\n\"b\"c\n"), ::testing::HasSubstr("line 2"));
  CsvReader reader("a\n\"b\nc\"\nd");
  reader.Next();
  reader.Next();
  EXPECT_EQ(reader.line(), 2);
  reader.Next();
  EXPECT_EQ(reader.line(), 4);
}

TEST(CsvReader, Utf16IsRefusedByName) {
  EXPECT_THAT(ErrorOf(std::string("\xff\xfe\x61\0", 4)), ::testing::HasSubstr("UTF-16"));
  EXPECT_THAT(ErrorOf(std::string("a\0,\0", 4)), ::testing::HasSubstr("UTF-16"));
}

}  // namespace
}  // namespace cairn
