// Read-only SQL on a map for people: `cairn sql`.
#ifndef CAIRN_STORAGE_MAP_SQL_SHELL_H_
#define CAIRN_STORAGE_MAP_SQL_SHELL_H_

#include <functional>
#include <string>
#include <vector>

namespace cairn {

// One value of a result row as text. NULL has empty text; a blob's text is its size.
struct SqlCell {
  std::string text;
  bool is_null = false;
  bool is_number = false;
};

// Receives results: for each statement that returns rows, first the column names, then the rows.
struct SqlSink {
  std::function<void(const std::vector<std::string>& column_names)> on_columns;
  std::function<void(const std::vector<SqlCell>& row)> on_row;
};

struct SqlOptions {
  double timeout_s = 60.0;  // For all statements together.

  void Validate() const;  // Throws Error(kInvalidArgument).
};

// Opens the map read-only, registers all inspection functions and virtual tables, and runs every
// statement of `sql`. Throws what MapStore::Open throws. Throws Error(kBadInput) if a statement
// fails, with SQLite's message; if a statement writes, attaches another file or changes a setting;
// and if the time is up. Messages quote the beginning of the statement.
void RunSql(const std::string& map_path, const std::string& sql, const SqlOptions& options,
            const SqlSink& sink);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_SQL_SHELL_H_
