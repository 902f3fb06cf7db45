#include "lab/experiments/result_table.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace cairn {
namespace {

TEST(ResultTable, WritesCsv) {
  std::vector<Column> columns = {{"method"}, {"k"}};
  AddIntervalColumns("precision", &columns);
  columns.push_back({"cpu_ms", true});
  ResultTable table(columns);
  std::vector<Cell> row = {"voting, \"4D\"", 4.0};
  AddIntervalCells({0.5, 0.25, 0.75}, &row);
  row.emplace_back(12.3456789);
  table.AddRow(row);
  table.AddRow({"none", 1.0, std::numeric_limits<double>::quiet_NaN(), 0.0, 1.0, 1e-7});
  EXPECT_EQ(table.Csv(),
            "method,k,precision,precision_low,precision_high,cpu_ms\n"
            "\"voting, \"\"4D\"\"\",4,0.5,0.25,0.75,12.3457\n"
            "none,1,,0,1,1e-07\n");
}

TEST(ResultTable, FindsColumns) {
  const ResultTable table({{"a"}, {"b"}});
  EXPECT_EQ(table.ColumnIndex("b"), 1u);
}

TEST(ResultTableDeathTest, RefusesARowOfAnotherLength) {
  ResultTable table({{"a"}, {"b"}});
  EXPECT_DEATH(table.AddRow({1.0}), "a row has one cell per column");
}

}  // namespace
}  // namespace cairn
