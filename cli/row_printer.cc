#include "cli/row_printer.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/csv.h"
#include "core/printable.h"

namespace cairn {
namespace {

constexpr size_t kMaxBufferedRows = 1000;

// Counts characters, not bytes: continuation bytes of UTF-8 take no column.
size_t DisplayWidth(std::string_view text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; });
}

class TablePrinter : public RowPrinter {
 public:
  void BeginResult(const std::vector<std::string>& column_names) override {
    Flush();
    if (num_results_++ > 0) {
      fmt::print("\n");
    }
    names_.clear();
    header_pending_ = true;
    widths_.clear();
    for (const std::string& name : column_names) {
      names_.push_back(Printable(name));
      widths_.push_back(DisplayWidth(names_.back()));
    }
  }

  void AddRow(const std::vector<SqlCell>& row) override {
    std::vector<SqlCell> printable = row;
    for (SqlCell& cell : printable) {
      cell.text = Printable(cell.text);
    }
    if (!header_pending_) {
      PrintRow(printable);
      return;
    }
    buffered_.push_back(std::move(printable));
    if (buffered_.size() >= kMaxBufferedRows) {
      Flush();
    }
  }

  void Finish() override { Flush(); }

 private:
  // Chooses the column widths from the buffered rows; prints the header and the rows.
  void Flush() {
    if (!header_pending_) {
      return;
    }
    header_pending_ = false;
    for (const std::vector<SqlCell>& row : buffered_) {
      for (size_t i = 0; i < row.size(); ++i) {
        widths_[i] = std::max(widths_[i], DisplayWidth(row[i].text));
      }
    }
    std::vector<SqlCell> header;
    std::vector<SqlCell> rule;
    for (size_t i = 0; i < names_.size(); ++i) {
      header.push_back({names_[i]});
      rule.push_back({std::string(widths_[i], '-')});
    }
    PrintRow(header);
    PrintRow(rule);
    for (const std::vector<SqlCell>& row : buffered_) {
      PrintRow(row);
    }
    buffered_.clear();
  }

  void PrintRow(const std::vector<SqlCell>& row) const {
    std::string line;
    for (size_t i = 0; i < row.size(); ++i) {
      const size_t width = DisplayWidth(row[i].text);
      const std::string padding(widths_[i] > width ? widths_[i] - width : 0, ' ');
      line += i > 0 ? "  " : "";
      line += row[i].is_number ? padding + row[i].text : row[i].text + padding;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    fmt::print("{}\n", line);
  }

  std::vector<std::string> names_;
  std::vector<size_t> widths_;
  std::vector<std::vector<SqlCell>> buffered_;
  bool header_pending_ = false;
  int num_results_ = 0;
};

class CsvPrinter : public RowPrinter {
 public:
  explicit CsvPrinter(bool for_terminal) : for_terminal_(for_terminal) {}

  void BeginResult(const std::vector<std::string>& column_names) override {
    std::vector<SqlCell> header;
    for (const std::string& name : column_names) {
      header.push_back({name});
    }
    AddRow(header);
  }

  void AddRow(const std::vector<SqlCell>& row) override {
    std::string line;
    for (size_t i = 0; i < row.size(); ++i) {
      line +=
          (i > 0 ? "," : "") + CsvText(for_terminal_ ? PrintableLines(row[i].text) : row[i].text);
    }
    fmt::print("{}\r\n", line);
  }

  void Finish() override {}

 private:
  bool for_terminal_;
};

class JsonPrinter : public RowPrinter {
 public:
  void BeginResult(const std::vector<std::string>& column_names) override {
    Finish();
    names_ = column_names;
    open_ = true;
    num_rows_ = 0;
    fmt::print("[");
  }

  void AddRow(const std::vector<SqlCell>& row) override {
    std::string line = num_rows_++ > 0 ? ",\n {" : "\n {";
    for (size_t i = 0; i < row.size(); ++i) {
      line += (i > 0 ? ", " : "") + Quoted(names_[i]) + ": " + Value(row[i]);
    }
    fmt::print("{}}}", line);
  }

  void Finish() override {
    if (open_) {
      fmt::print("{}]\n", num_rows_ > 0 ? "\n" : "");
      open_ = false;
    }
  }

 private:
  // Quotes in ASCII, so that no character controls a terminal.
  static std::string Quoted(const std::string& text) {
    return nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  }

  // SQLite prints infinities as "Inf", which is not JSON.
  static std::string Value(const SqlCell& cell) {
    if (cell.is_null) {
      return "null";
    }
    return cell.is_number && nlohmann::json::accept(cell.text) ? cell.text : Quoted(cell.text);
  }

  std::vector<std::string> names_;
  bool open_ = false;
  int num_rows_ = 0;
};

}  // namespace

std::unique_ptr<RowPrinter> MakeRowPrinter(RowFormat format, bool for_terminal) {
  switch (format) {
    case RowFormat::kCsv:
      return std::make_unique<CsvPrinter>(for_terminal);
    case RowFormat::kJson:
      return std::make_unique<JsonPrinter>();
    case RowFormat::kTable:
      break;
  }
  return std::make_unique<TablePrinter>();
}

}  // namespace cairn
