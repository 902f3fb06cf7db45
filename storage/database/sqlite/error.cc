#include "storage/database/sqlite/error.h"

#include <sqlite3.h>

#include <new>

#include "core/printable.h"

namespace cairn::sqlite {
namespace {

std::string MessageOf(sqlite3* db, int result, const std::string& path, const char* action) {
  return path + ": cannot " + action + ": " + DetailOf(db, result);
}

bool IsOutOfMemory(int result) {
  return (result & 0xff) == SQLITE_NOMEM || result == SQLITE_IOERR_NOMEM;
}

void ThrowIfOutOfMemory(int result) {
  if (IsOutOfMemory(result)) {
    throw std::bad_alloc();
  }
}

}  // namespace

std::string DetailOf(sqlite3* db, int result) {
  constexpr size_t kMaxDetailBytes = 300;
  const char* detail = db == nullptr ? sqlite3_errstr(result) : sqlite3_errmsg(db);
  return "SQLite says \"" + Excerpt(detail, kMaxDetailBytes) + "\"";
}

ErrorCode CodeFromResult(int result) {
  if (result == SQLITE_IOERR_SHORT_READ) {
    return ErrorCode::kMapDamaged;
  }
  switch (result & 0xff) {
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_FORMAT:
      return ErrorCode::kMapDamaged;
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return ErrorCode::kConflict;
    case SQLITE_CANTOPEN:
    case SQLITE_IOERR:
    case SQLITE_FULL:
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return ErrorCode::kIo;
    default:
      return ErrorCode::kInternal;
  }
}

ErrorCode CodeFromContent(int result) {
  const ErrorCode code = CodeFromResult(result);
  const bool is_ours = IsOutOfMemory(result) || (result & 0xff) == SQLITE_MISUSE;
  return code == ErrorCode::kInternal && !is_ours ? ErrorCode::kMapDamaged : code;
}

void ThrowError(sqlite3* db, int result, const std::string& path, const char* action) {
  ThrowIfOutOfMemory(result);
  throw Error(CodeFromResult(result), MessageOf(db, result, path, action));
}

void ThrowContentError(sqlite3* db, int result, const std::string& path, const char* action) {
  ThrowIfOutOfMemory(result);
  if ((result & 0xff) == SQLITE_INTERRUPT) {
    throw Error(ErrorCode::kMapDamaged,
                path + ": cannot " + action +
                    ": this takes far more work than in an undamaged file of this size; "
                    "the file's pages may form cycles");
  }
  throw Error(CodeFromContent(result), MessageOf(db, result, path, action));
}

}  // namespace cairn::sqlite
