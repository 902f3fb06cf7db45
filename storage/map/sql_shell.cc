#include "storage/map/sql_shell.h"

#include <sqlite3.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string_view>
#include <thread>

#include "core/error.h"
#include "core/printable.h"
#include "core/require.h"
#include "storage/database/sqlite/connection.h"
#include "storage/database/sqlite/error.h"
#include "storage/inspection/register.h"
#include "storage/map/internal/map_file.h"
#include "storage/map/internal/postgres_backend.h"

namespace cairn {
namespace {

using StatementPtr = std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)>;

constexpr size_t kMaxQuotedSqlBytes = 300;

// Pragmas that only report something.
constexpr std::string_view kPragmas[] = {
    "application_id",  "compile_options", "database_list", "foreign_key_check", "foreign_key_list",
    "freelist_count",  "function_list",   "index_info",    "index_list",        "index_xinfo",
    "integrity_check", "module_list",     "page_count",    "page_size",         "quick_check",
    "table_info",      "table_list",      "table_xinfo",   "user_version",
};

// The connection is read-only. The authorizer refuses the rest: other files and changes of
// settings.
int Authorize(void* /*user_data*/, int action, const char* first, const char* /*second*/,
              const char* /*database*/, const char* /*trigger*/) {
  if (action == SQLITE_ATTACH || action == SQLITE_DETACH) {
    return SQLITE_DENY;
  }
  if (action == SQLITE_PRAGMA &&
      std::find(std::begin(kPragmas), std::end(kPragmas), first) == std::end(kPragmas)) {
    return SQLITE_DENY;
  }
  return SQLITE_OK;
}

// Interrupts a connection once the time is up. SQLite counts the rows of a table without calling a
// progress handler, so a progress handler would not suffice.
class Watchdog {
 public:
  Watchdog(sqlite3* db, double timeout_s)
      : thread_([db, timeout_s](const std::stop_token& stop) {
          const auto until = std::chrono::steady_clock::now() +
                             std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                 std::chrono::duration<double>(timeout_s));
          std::mutex mutex;
          std::condition_variable_any wake;
          std::unique_lock lock(mutex);
          wake.wait_until(lock, stop, until, [] { return false; });
          // Repeats the interrupt for statements that begin later.
          while (!stop.stop_requested()) {
            sqlite3_interrupt(db);
            wake.wait_for(lock, stop, std::chrono::milliseconds(10), [] { return false; });
          }
        }) {}

 private:
  std::jthread thread_;  // Stopped and joined on destruction.
};

// Throws the error of a failed statement. Failures that neither the map nor the machine causes are
// the statement's fault: Error(kBadInput).
[[noreturn]] void ThrowStatementError(const sqlite::Connection& connection, int result) {
  if ((result & 0xff) == SQLITE_INTERRUPT) {
    throw Error(ErrorCode::kBadInput,
                "SQL: stopped because the time is up; set a longer --timeout or select fewer rows");
  }
  const ErrorCode code = sqlite::CodeFromResult(result);
  if (code == ErrorCode::kInternal) {
    throw Error(ErrorCode::kBadInput,
                "SQL: " + Excerpt(sqlite3_errmsg(connection.handle()), kMaxQuotedSqlBytes));
  }
  sqlite::ThrowError(connection.handle(), result, connection.path(), "read");
}

SqlCell CellOf(sqlite3_stmt* statement, int column) {
  const int type = sqlite3_column_type(statement, column);
  SqlCell cell;
  cell.is_null = type == SQLITE_NULL;
  cell.is_number = type == SQLITE_INTEGER || type == SQLITE_FLOAT;
  if (type == SQLITE_BLOB) {
    cell.text = "<" + std::to_string(sqlite3_column_bytes(statement, column)) + " bytes>";
  } else if (!cell.is_null) {
    const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement, column));
    cell.text.assign(text, static_cast<size_t>(sqlite3_column_bytes(statement, column)));
  }
  return cell;
}

void RunStatement(const sqlite::Connection& connection, sqlite3_stmt* statement,
                  const SqlSink& sink) {
  if (sqlite3_stmt_readonly(statement) == 0) {
    throw Error(ErrorCode::kBadInput,
                "SQL: this statement writes, but `cairn sql` only reads maps: " +
                    Excerpt(sqlite3_sql(statement)));
  }
  const int num_columns = sqlite3_column_count(statement);
  if (num_columns > 0) {
    std::vector<std::string> names;
    for (int i = 0; i < num_columns; ++i) {
      names.emplace_back(sqlite3_column_name(statement, i));
    }
    sink.on_columns(names);
  }
  int result = sqlite3_step(statement);
  for (; result == SQLITE_ROW; result = sqlite3_step(statement)) {
    std::vector<SqlCell> row;
    for (int i = 0; i < num_columns; ++i) {
      row.push_back(CellOf(statement, i));
    }
    sink.on_row(row);
  }
  if (result != SQLITE_DONE) {
    ThrowStatementError(connection, result);
  }
}

}  // namespace

void SqlOptions::Validate() const { RequireWithin("timeout_s", timeout_s, 1e-3, 1e6); }

void RunSql(const std::string& map_path, const std::string& sql, const SqlOptions& options,
            const SqlSink& sink) {
  if (IsServerAddress(map_path)) {
    // Without the URL, which may hold a password.
    throw Error(ErrorCode::kInvalidArgument,
                "`cairn sql` reads files; give the URL to psql, and see the tables of the schema "
                "cairn");
  }
  options.Validate();
  sqlite::Access access = sqlite::Access::kReadOnly;
  const std::unique_ptr<sqlite::Connection> connection = OpenMapFile(map_path, &access);
  connection->TrustSchema();  // The views read R*Trees.
  if (const int result = inspection::RegisterInspection(connection->handle());
      result != SQLITE_OK) {
    sqlite::ThrowError(connection->handle(), result, map_path, "register functions");
  }
  sqlite3_set_authorizer(connection->handle(), &Authorize, nullptr);
  connection->LiftWorkLimit();
  const Watchdog watchdog(connection->handle(), options.timeout_s);

  const char* next = sql.c_str();
  while (*next != '\0') {
    sqlite3_stmt* handle = nullptr;
    const int result = sqlite3_prepare_v2(connection->handle(), next, -1, &handle, &next);
    const StatementPtr statement(handle, &sqlite3_finalize);
    if (result != SQLITE_OK) {
      ThrowStatementError(*connection, result);
    }
    if (handle != nullptr) {  // The text held more than blanks and comments.
      RunStatement(*connection, handle, sink);
    }
  }
}

}  // namespace cairn
