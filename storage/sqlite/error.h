// SQLite's result codes as cairn::Error.
#ifndef CAIRN_STORAGE_SQLITE_ERROR_H_
#define CAIRN_STORAGE_SQLITE_ERROR_H_

#include <string>

#include "core/error.h"

struct sqlite3;

namespace cairn::sqlite {

// What kind of failure a result code is: damage for SQLITE_CORRUPT and its like, kConflict for
// locks, kIo for what the operating system refused, else kInternal.
ErrorCode CodeFromResult(int result);

// Throws Error with `path`, `action` ("read", "write", ...) and SQLite's own message. `db` may be
// null if there is no connection yet.
[[noreturn]] void ThrowError(sqlite3* db, int result, const std::string& path, const char* action);

}  // namespace cairn::sqlite

#endif  // CAIRN_STORAGE_SQLITE_ERROR_H_
