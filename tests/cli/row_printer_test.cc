#include "cli/row_printer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace cairn {
namespace {

std::string Print(RowFormat format, const std::vector<std::vector<SqlCell>>& rows) {
  ::testing::internal::CaptureStdout();
  const std::unique_ptr<RowPrinter> printer = MakeRowPrinter(format, false);
  printer->BeginResult({"name", "n"});
  for (const std::vector<SqlCell>& row : rows) {
    printer->AddRow(row);
  }
  printer->Finish();
  std::fflush(stdout);
  return ::testing::internal::GetCapturedStdout();
}

SqlCell Text(const std::string& text) { return {text, false, false}; }
SqlCell Number(const std::string& text) { return {text, false, true}; }

TEST(RowPrinter, AlignsNumbersRightAndTextLeft) {
  EXPECT_EQ(
      Print(RowFormat::kTable, {{Text("a"), Number("1")}, {Text("long name"), Number("100")}}),
      "name       n\n---------  ---\na            1\nlong name  100\n");
}

TEST(RowPrinter, CountsCharactersNotBytes) {
  EXPECT_EQ(Print(RowFormat::kTable, {{Text("Z\xC3\xBCrich"), Number("1")}}),
            "name    n\n------  -\nZ\xC3\xBCrich  1\n");
}

TEST(RowPrinter, PrintsRowsBeyondTheBufferToo) {
  const std::vector<std::vector<SqlCell>> rows(2500, {Text("a"), Number("1")});
  const std::string out = Print(RowFormat::kTable, rows);
  EXPECT_EQ(std::count(out.begin(), out.end(), '\n'), 2502);
}

TEST(RowPrinter, JsonQuotesWhatIsNoJsonNumber) {
  EXPECT_EQ(Print(RowFormat::kJson, {{Text("a\nb"), Number("Inf")}}),
            "[\n {\"name\": \"a\\nb\", \"n\": \"Inf\"}\n]\n");
}

TEST(RowPrinter, JsonOfNoRowsIsAnEmptyArray) { EXPECT_EQ(Print(RowFormat::kJson, {}), "[]\n"); }

}  // namespace
}  // namespace cairn
