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

// The same for a statement of our own on a file from outside. Such a statement is right, so that
// what SQLite refuses of it (a number too large, a constraint, endless work) is the file's fault:
// damage where the above says kInternal, unless memory is short.
ErrorCode CodeFromContent(int result);

// "SQLite says "..."" with what the connection says last, cut: SQLite quotes names and values of
// the file. `db` may be null if there is no connection yet.
std::string DetailOf(sqlite3* db, int result);

// Throws Error with `path`, `action` ("read", "write", ...) and SQLite's own message, or
// std::bad_alloc if SQLite got no memory. `db` may be null if there is no connection yet.
[[noreturn]] void ThrowError(sqlite3* db, int result, const std::string& path, const char* action);

// The same with the code of CodeFromContent.
[[noreturn]] void ThrowContentError(sqlite3* db, int result, const std::string& path,
                                    const char* action);

}  // namespace cairn::sqlite

#endif  // CAIRN_STORAGE_SQLITE_ERROR_H_
