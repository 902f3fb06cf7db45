#include "storage/database/sqlite/blob.h"

#include <sqlite3.h>

#include <memory>

#include "core/error.h"
#include "storage/database/sqlite/error.h"

namespace cairn::sqlite {
namespace {

// Below this size, the file size need not be queried.
constexpr size_t kAlwaysAllowedBytes = size_t{64} << 20;

}  // namespace

std::optional<LargeVector<uint8_t>> ReadBlob(Connection* connection, const char* table,
                                             const char* column, int64_t row_id) {
  sqlite3_blob* handle = nullptr;
  const int opened =
      sqlite3_blob_open(connection->handle(), "main", table, column, row_id, 0, &handle);
  const std::unique_ptr<sqlite3_blob, decltype(&sqlite3_blob_close)> blob(handle,
                                                                          &sqlite3_blob_close);
  if (opened == SQLITE_ERROR) {
    return std::nullopt;
  }
  if (opened != SQLITE_OK) {
    ThrowError(connection->handle(), opened, connection->path(), "read a blob");
  }
  const auto num_bytes = static_cast<size_t>(sqlite3_blob_bytes(handle));
  // If the pages of a blob form a cycle, the blob can claim any size, so it is compared with the
  // file size.
  if (num_bytes > kAlwaysAllowedBytes && num_bytes > connection->FileBytes()) {
    throw Error(ErrorCode::kMapDamaged, connection->path() + ": " + table + "." + column +
                                            " claims more bytes than the file has");
  }
  LargeVector<uint8_t> bytes(num_bytes);
  const int read = sqlite3_blob_read(handle, bytes.data(), static_cast<int>(bytes.size()), 0);
  if (read != SQLITE_OK) {
    ThrowError(connection->handle(), read, connection->path(), "read a blob");
  }
  return bytes;
}

}  // namespace cairn::sqlite
