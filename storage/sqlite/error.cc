#include "storage/sqlite/error.h"

#include <sqlite3.h>

namespace cairn::sqlite {

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

void ThrowError(sqlite3* db, int result, const std::string& path, const char* action) {
  const char* detail = db == nullptr ? sqlite3_errstr(result) : sqlite3_errmsg(db);
  throw Error(CodeFromResult(result),
              path + ": cannot " + action + ": SQLite says \"" + detail + "\"");
}

}  // namespace cairn::sqlite
