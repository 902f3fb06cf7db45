// Converts SQLite's result codes to cairn::Error.
#ifndef CAIRN_STORAGE_DATABASE_SQLITE_ERROR_H_
#define CAIRN_STORAGE_DATABASE_SQLITE_ERROR_H_

#include <string>

#include "core/error.h"

struct sqlite3;

namespace cairn::sqlite {

// Classifies a result code: kMapDamaged for SQLITE_CORRUPT and similar codes, kConflict for locks,
// kIo for refusals of the operating system, else kInternal.
ErrorCode CodeFromResult(int result);

// Classifies a result code of one of Cairn's own statements on an untrusted file. Cairn's
// statements are valid, so a failure such as an overflow, a violated constraint or too much work is
// the file's fault: kMapDamaged where CodeFromResult returns kInternal, unless memory ran out.
ErrorCode CodeFromContent(int result);

// Returns "SQLite says "..."" with the connection's last message, shortened, since SQLite quotes
// names and values of the file. `db` may be null if there is no connection yet.
std::string DetailOf(sqlite3* db, int result);

// Throws Error with `path`, `action` ("read", "write", ...) and SQLite's message, or std::bad_alloc
// if SQLite ran out of memory. `db` may be null if there is no connection yet.
[[noreturn]] void ThrowError(sqlite3* db, int result, const std::string& path, const char* action);

// Like ThrowError, with the code of CodeFromContent.
[[noreturn]] void ThrowContentError(sqlite3* db, int result, const std::string& path,
                                    const char* action);

}  // namespace cairn::sqlite

#endif  // CAIRN_STORAGE_DATABASE_SQLITE_ERROR_H_
