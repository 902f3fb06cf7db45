// The rows that an experiment measures, with their CSV form.
#ifndef CAIRN_LAB_EXPERIMENTS_RESULT_TABLE_H_
#define CAIRN_LAB_EXPERIMENTS_RESULT_TABLE_H_

#include <cstddef>
#include <string>
#include <variant>
#include <vector>

#include "eval/evaluation_bootstrap.h"

namespace cairn {

using Cell = std::variant<std::string, double>;

struct Column {
  std::string name;  // With its unit: "cpu_ms". An interval has x, x_low, x_high.
  // The value depends on the machine and its load. The report lists such columns last.
  bool is_timing = false;
};

// A table with rows of equal length. A plain value.
class ResultTable {
 public:
  ResultTable() = default;
  explicit ResultTable(std::vector<Column> columns);

  // The row must have one cell per column.
  void AddRow(std::vector<Cell> row);

  const std::vector<Column>& columns() const { return columns_; }
  const std::vector<std::vector<Cell>>& rows() const { return rows_; }

  // Returns the index of a column, which must exist.
  size_t ColumnIndex(const std::string& name) const;

  // RFC 4180 with a header line and six significant digits. A number that is not finite becomes an
  // empty field.
  std::string Csv() const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<Cell>> rows_;
};

// Appends `name`, `name`_low and `name`_high to `columns`.
void AddIntervalColumns(const std::string& name, std::vector<Column>* columns);
// Appends the interval's three cells to `row`.
void AddIntervalCells(const Interval& interval, std::vector<Cell>* row);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_RESULT_TABLE_H_
