#include "storage/database/sqlite/connection.h"

#include <sqlite3.h>

#include <filesystem>
#include <system_error>

#include "core/error.h"
#include "storage/database/sqlite/error.h"

namespace cairn::sqlite {
namespace {

// The work limit grows with the file size: a scan takes tens of steps per row, and the smallest row
// takes some bytes. The base covers rows that are not in the file yet but in SQLite's 2 MB cache.
constexpr int kStepsACall = 1000;
constexpr int64_t kBaseSteps = 20'000'000;
constexpr int64_t kStepsAByte = 20;

// Returns the "file:" URI of a path. In a URI, %, ? and # have a special meaning and are escaped.
std::string ImmutableUri(const std::string& absolute_path) {
  std::string uri = "file:";
  for (const char c : absolute_path) {
    if (c == '%' || c == '?' || c == '#') {
      constexpr char kDigits[] = "0123456789ABCDEF";
      uri += {'%', kDigits[c >> 4], kDigits[c & 15]};
    } else {
      uri += c;
    }
  }
  return uri + "?immutable=1";
}

int OpenFlags(Access access) {
  constexpr int kCommon = SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
  switch (access) {
    case Access::kCreate:
      return kCommon | SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
    case Access::kReadWrite:
      return kCommon | SQLITE_OPEN_READWRITE;
    case Access::kReadOnly:
      return kCommon | SQLITE_OPEN_READONLY;
    case Access::kImmutable:
      return kCommon | SQLITE_OPEN_READONLY | SQLITE_OPEN_URI;
    case Access::kMemory:
      return kCommon | SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_MEMORY;
  }
  throw Error(ErrorCode::kInternal, "unknown sqlite::Access");
}

}  // namespace

Connection::Connection(const std::string& path, Access access, int busy_timeout_ms) : path_(path) {
  // An absolute path cannot be mistaken for a special name such as ":memory:".
  const std::string absolute = std::filesystem::absolute(path).string();
  const std::string name = access == Access::kImmutable ? ImmutableUri(absolute)
                           : access == Access::kMemory  ? ":memory:"
                                                        : absolute;
  if (const int result = sqlite3_open_v2(name.c_str(), &handle_, OpenFlags(access), nullptr);
      result != SQLITE_OK) {
    const std::string detail = DetailOf(handle_, result);
    Close();
    throw Error(CodeFromResult(result), path + ": cannot open: " + detail);
  }
  sqlite3_busy_timeout(handle_, busy_timeout_ms);
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_ENABLE_FKEY, 1, nullptr);
  sqlite3_progress_handler(handle_, kStepsACall, &OnProgress, this);
  sqlite3_exec(handle_, "PRAGMA cell_size_check = ON", nullptr, nullptr, nullptr);
}

Connection::~Connection() { Close(); }

void Connection::Close() noexcept {
  for (const auto& [sql, statement] : idle_statements_) {
    sqlite3_finalize(statement);
  }
  idle_statements_.clear();
  sqlite3_close_v2(handle_);
  handle_ = nullptr;
}

void Connection::TrustSchema() {
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 1, nullptr);
}

void Connection::LiftWorkLimit() { sqlite3_progress_handler(handle_, 0, nullptr, nullptr); }

uint64_t Connection::FileBytes() const {
  uint64_t num_bytes = 0;
  for (const char* suffix : {"", "-wal"}) {
    std::error_code error;
    const auto size = std::filesystem::file_size(path_ + suffix, error);
    num_bytes += error ? 0 : size;
  }
  return num_bytes;
}

int Connection::OnProgress(void* connection) {
  return static_cast<Connection*>(connection)->MayGoOn() ? 0 : 1;
}

bool Connection::MayGoOn() {
  num_steps_ += kStepsACall;
  if (num_steps_ > max_steps_) {  // The file may have grown; update the limit.
    max_steps_ = kBaseSteps + kStepsAByte * static_cast<int64_t>(FileBytes());
  }
  return num_steps_ <= max_steps_;
}

void Connection::ResetSteps() {
  if (num_statements_ == 0) {
    num_steps_ = 0;
  }
}

void Connection::Execute(const std::string& script) {
  ResetSteps();
  if (const int result = sqlite3_exec(handle_, script.c_str(), nullptr, nullptr, nullptr);
      result != SQLITE_OK) {
    ThrowContentError(handle_, result, path_, "run a statement");
  }
}

Statement Connection::Prepare(std::string_view sql) {
  ResetSteps();
  if (auto idle = idle_statements_.extract(std::string(sql)); !idle.empty()) {
    ++num_statements_;
    return {this, idle.mapped()};
  }
  sqlite3_stmt* statement = nullptr;
  const int result = sqlite3_prepare_v3(handle_, sql.data(), static_cast<int>(sql.size()),
                                        SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  if (result == SQLITE_ERROR) {
    throw Error(ErrorCode::kMapDamaged,
                path_ + ": its tables are not those of a Cairn map: " + DetailOf(handle_, result));
  }
  if (result != SQLITE_OK) {
    ThrowContentError(handle_, result, path_, "read the schema");
  }
  ++num_statements_;
  return {this, statement};
}

void Connection::GiveBack(sqlite3_stmt* statement) noexcept {
  --num_statements_;
  sqlite3_reset(statement);
  sqlite3_clear_bindings(statement);
  try {
    if (idle_statements_.emplace(sqlite3_sql(statement), statement).second) {
      return;
    }
  } catch (const std::bad_alloc&) {
    // No memory for the cache: the statement is compiled again next time.
  }
  sqlite3_finalize(statement);
}

int64_t Connection::LastInsertId() const { return sqlite3_last_insert_rowid(handle_); }

int64_t Connection::NumChanges() const { return sqlite3_changes64(handle_); }

}  // namespace cairn::sqlite
