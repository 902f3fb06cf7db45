// Prints query results as an aligned table, CSV or JSON.
#ifndef CAIRN_CLI_ROW_PRINTER_H_
#define CAIRN_CLI_ROW_PRINTER_H_

#include <memory>

#include "storage/map/sql_shell.h"

namespace cairn {

enum class RowFormat {
  kTable,  // Columns are aligned on the first thousand rows; NULL is empty.
  kCsv,    // RFC 4180 with a header; NULL is an empty field.
  kJson,   // One array of objects for each result.
};

// Prints the rows of any number of consecutive results to stdout, for example as the sink of
// RunSql. Use from one thread.
class RowPrinter {
 public:
  virtual ~RowPrinter() = default;
  virtual void BeginResult(const std::vector<std::string>& column_names) = 0;
  virtual void AddRow(const std::vector<SqlCell>& row) = 0;
  // Ends the last result. Must be called exactly once, at the end.
  virtual void Finish() = 0;
};

// Tables and JSON escape control characters, and CSV does so for a terminal. For programs, CSV
// keeps values unchanged.
std::unique_ptr<RowPrinter> MakeRowPrinter(RowFormat format, bool for_terminal);

}  // namespace cairn

#endif  // CAIRN_CLI_ROW_PRINTER_H_
