// The rows that an experiment measures, and their form as CSV.
#ifndef CAIRN_LAB_EXPERIMENTS_REPORT_RESULT_TABLE_H_
#define CAIRN_LAB_EXPERIMENTS_REPORT_RESULT_TABLE_H_

#include <cstddef>
#include <string>
#include <variant>
#include <vector>

#include "eval/evaluation_bootstrap.h"

namespace cairn {

using Cell = std::variant<std::string, double>;

struct Column {
  std::string name;  // With its unit: "cpu_ms". An interval of `x` has columns x, x_low, x_high.
  // Depends on the machine and its load; the report lists such columns last.
  bool is_timing = false;
};

// Rows of equal length. A plain value.
class ResultTable {
 public:
  ResultTable() = default;
  explicit ResultTable(std::vector<Column> columns);

  // The row must have a cell a column.
  void AddRow(std::vector<Cell> row);

  const std::vector<Column>& columns() const { return columns_; }
  const std::vector<std::vector<Cell>>& rows() const { return rows_; }

  // Index of a column, which must exist.
  size_t ColumnIndex(const std::string& name) const;

  // RFC 4180 with a header line; six significant digits, numbers that are none are empty.
  std::string Csv() const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<Cell>> rows_;
};

// `name`, `name`_low, `name`_high at the end of `columns`.
void AddIntervalColumns(const std::string& name, std::vector<Column>* columns);
// Its three cells at the end of `row`.
void AddIntervalCells(const Interval& interval, std::vector<Cell>* row);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_REPORT_RESULT_TABLE_H_
