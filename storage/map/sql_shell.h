// Read-only SQL over a map for people: `cairn sql`.
#ifndef CAIRN_STORAGE_MAP_SQL_SHELL_H_
#define CAIRN_STORAGE_MAP_SQL_SHELL_H_

#include <functional>
#include <string>
#include <vector>

namespace cairn {

// One value of a result row, as text. NULL has no text; a blob shows its size.
struct SqlCell {
  std::string text;
  bool is_null = false;
  bool is_number = false;
};

// Where results go: for each statement that gives any, its columns and then its rows.
struct SqlSink {
  std::function<void(const std::vector<std::string>& column_names)> on_columns;
  std::function<void(const std::vector<SqlCell>& row)> on_row;
};

struct SqlOptions {
  double timeout_s = 60.0;  // For all statements together.

  void Validate() const;  // Throws Error(kInvalidArgument).
};

// Opens the map read-only with all inspection functions and virtual tables registered and runs
// every statement of `sql`. Throws Error(kBadInput) with SQLite's message on an SQL error or an
// attempt to write, to attach another file or to change a setting, or when the time is up, and as
// MapStore::Open. Messages quote the beginning of a statement.
void RunSql(const std::string& map_path, const std::string& sql, const SqlOptions& options,
            const SqlSink& sink);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_SQL_SHELL_H_
