#include "lab/experiments/result_table.h"

#include <algorithm>
#include <utility>

#include "core/check.h"
#include "core/csv.h"

namespace cairn {
namespace {

std::string CsvCell(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) {
    return CsvText(*text);
  }
  return CsvNumber(std::get<double>(cell));
}

}  // namespace

ResultTable::ResultTable(std::vector<Column> columns) : columns_(std::move(columns)) {}

void ResultTable::AddRow(std::vector<Cell> row) {
  CAIRN_CHECK(row.size() == columns_.size(), "a row has one cell per column");
  rows_.push_back(std::move(row));
}

size_t ResultTable::ColumnIndex(const std::string& name) const {
  const auto found = std::find_if(columns_.begin(), columns_.end(),
                                  [&](const Column& column) { return column.name == name; });
  CAIRN_CHECK(found != columns_.end(), "the table has no such column");
  return static_cast<size_t>(found - columns_.begin());
}

std::string ResultTable::Csv() const {
  std::string text;
  for (size_t i = 0; i < columns_.size(); ++i) {
    text += (i == 0 ? "" : ",") + CsvText(columns_[i].name);
  }
  text += "\n";
  for (const std::vector<Cell>& row : rows_) {
    for (size_t i = 0; i < row.size(); ++i) {
      text += (i == 0 ? "" : ",") + CsvCell(row[i]);
    }
    text += "\n";
  }
  return text;
}

void AddIntervalColumns(const std::string& name, std::vector<Column>* columns) {
  for (const char* suffix : {"", "_low", "_high"}) {
    columns->push_back({name + suffix});
  }
}

void AddIntervalCells(const Interval& interval, std::vector<Cell>* row) {
  for (const double value : {interval.value, interval.low, interval.high}) {
    row->emplace_back(value);
  }
}

}  // namespace cairn
