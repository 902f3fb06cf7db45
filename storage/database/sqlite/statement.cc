#include "storage/database/sqlite/statement.h"

#include <sqlite3.h>

#include <utility>

#include "core/error.h"
#include "storage/database/sqlite/connection.h"
#include "storage/database/sqlite/error.h"

namespace cairn::sqlite {

Statement::Statement(Connection* connection, sqlite3_stmt* handle)
    : connection_(connection), handle_(handle) {}

Statement::Statement(Statement&& other) noexcept
    : connection_(other.connection_), handle_(std::exchange(other.handle_, nullptr)) {}

Statement::~Statement() {
  if (handle_ != nullptr) {
    connection_->GiveBack(handle_);
  }
}

bool Statement::Step() {
  const int result = sqlite3_step(handle_);
  if (result == SQLITE_ROW) {
    return true;
  }
  if (result != SQLITE_DONE) {
    const char* action = sqlite3_stmt_readonly(handle_) != 0 ? "read" : "write";
    ThrowContentError(connection_->handle(), result, connection_->path(), action);
  }
  return false;
}

void Statement::Run() {
  Step();
  sqlite3_reset(handle_);
}

int64_t Statement::Int64(int column) const {
  CheckType(column, SQLITE_INTEGER);
  return sqlite3_column_int64(handle_, column);
}

double Statement::Double(int column) const {
  CheckType(column, SQLITE_FLOAT);
  return sqlite3_column_double(handle_, column);
}

double Statement::Number(int column) const {
  const bool is_whole = sqlite3_column_type(handle_, column) == SQLITE_INTEGER;
  return is_whole ? static_cast<double>(Int64(column)) : Double(column);
}

std::string Statement::Text(int column) const {
  CheckType(column, SQLITE_TEXT);
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(handle_, column));
  return {text, static_cast<size_t>(sqlite3_column_bytes(handle_, column))};
}

std::vector<uint8_t> Statement::Blob(int column) const {
  CheckType(column, SQLITE_BLOB);
  const auto* bytes = static_cast<const uint8_t*>(sqlite3_column_blob(handle_, column));
  return {bytes, bytes + sqlite3_column_bytes(handle_, column)};
}

bool Statement::IsNull(int column) const {
  return sqlite3_column_type(handle_, column) == SQLITE_NULL;
}

void Statement::BindAt(int index, int64_t value) {
  CheckBound(sqlite3_bind_int64(handle_, index, value));
}

void Statement::BindAt(int index, double value) {
  CheckBound(sqlite3_bind_double(handle_, index, value));
}

void Statement::BindAt(int index, std::string_view value) {
  CheckBound(sqlite3_bind_text64(handle_, index, value.data(), value.size(), SQLITE_TRANSIENT,
                                 SQLITE_UTF8));
}

void Statement::BindAt(int index, std::span<const uint8_t> value) {
  CheckBound(sqlite3_bind_blob64(handle_, index, value.data(), value.size(), SQLITE_STATIC));
}

void Statement::CheckType(int column, int type) const {
  if (sqlite3_column_type(handle_, column) != type) {
    throw Error(ErrorCode::kMapDamaged, connection_->path() + ": column " +
                                            sqlite3_column_name(handle_, column) +
                                            " holds a value of the wrong type");
  }
}

void Statement::CheckBound(int result) const {
  if (result != SQLITE_OK) {
    ThrowError(connection_->handle(), result, connection_->path(), "bind a value");
  }
}

}  // namespace cairn::sqlite
