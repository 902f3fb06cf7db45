// Incremental blob I/O, which reads a blob directly into its destination.
#ifndef CAIRN_STORAGE_DATABASE_SQLITE_BLOB_H_
#define CAIRN_STORAGE_DATABASE_SQLITE_BLOB_H_

#include <cstdint>
#include <optional>

#include "core/large_vector.h"
#include "storage/database/sqlite/connection.h"

namespace cairn::sqlite {

// Returns the bytes of a blob in a rowid table of the main database; nothing if the row does not
// exist. Copies the bytes once; a SELECT would copy them twice. Throws Error.
std::optional<LargeVector<uint8_t>> ReadBlob(Connection* connection, const char* table,
                                             const char* column, int64_t row_id);

}  // namespace cairn::sqlite

#endif  // CAIRN_STORAGE_DATABASE_SQLITE_BLOB_H_
