// Prints query results as an aligned table, CSV or JSON.
#ifndef CAIRN_CLI_ROW_PRINTER_H_
#define CAIRN_CLI_ROW_PRINTER_H_

#include <memory>

#include "storage/map/sql_shell.h"

namespace cairn {

enum class RowFormat {
  kTable,  // Columns aligned on the first thousand rows; NULL is empty.
  kCsv,    // RFC 4180 with a header; NULL is an empty field.
  kJson,   // One array of objects a result.
};

// Takes the rows of any number of results in turn, e.g. as the sink of RunSql, and prints them to
// stdout. One thread.
class RowPrinter {
 public:
  virtual ~RowPrinter() = default;
  virtual void BeginResult(const std::vector<std::string>& column_names) = 0;
  virtual void AddRow(const std::vector<SqlCell>& row) = 0;
  // Ends the last result. Must be called once, at the end.
  virtual void Finish() = 0;
};

// What a terminal might obey is escaped in tables and JSON, and in CSV if it is for a terminal:
// programs get values as they are.
std::unique_ptr<RowPrinter> MakeRowPrinter(RowFormat format, bool for_terminal);

}  // namespace cairn

#endif  // CAIRN_CLI_ROW_PRINTER_H_
