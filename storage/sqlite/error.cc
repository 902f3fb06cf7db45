#include "storage/sqlite/error.h"

#include <sqlite3.h>

#include "core/printable.h"

namespace cairn::sqlite {
namespace {

std::string MessageOf(sqlite3* db, int result, const std::string& path, const char* action) {
  return path + ": cannot " + action + ": " + DetailOf(db, result);
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
  const bool is_ours = (result & 0xff) == SQLITE_NOMEM || (result & 0xff) == SQLITE_MISUSE;
  return code == ErrorCode::kInternal && !is_ours ? ErrorCode::kMapDamaged : code;
}

void ThrowError(sqlite3* db, int result, const std::string& path, const char* action) {
  throw Error(CodeFromResult(result), MessageOf(db, result, path, action));
}

void ThrowContentError(sqlite3* db, int result, const std::string& path, const char* action) {
  if ((result & 0xff) == SQLITE_INTERRUPT) {
    throw Error(ErrorCode::kMapDamaged,
                path + ": cannot " + action +
                    ": this takes far more work than a sound file of its size; its pages refer to "
                    "each other in circles");
  }
  throw Error(CodeFromContent(result), MessageOf(db, result, path, action));
}

}  // namespace cairn::sqlite
