// A connection to the database that holds a map: an SQLite file or a PostgreSQL database.
#ifndef CAIRN_STORAGE_DATABASE_CONNECTION_H_
#define CAIRN_STORAGE_DATABASE_CONNECTION_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/large_vector.h"
#include "storage/database/statement.h"

namespace cairn::db {

// For statements that must differ between the databases.
enum class Dialect { kSqlite, kPostgres };

// Use each connection from one thread at a time. Parameters are ? or ?1, ?2, ..., not mixed.
class Connection {
 public:
  virtual ~Connection() = default;

  // The path of the file or the URL, for messages. A URL has no password.
  virtual const std::string& name() const = 0;
  virtual Dialect dialect() const = 0;
  // Returns the size of the map on disk, bytes.
  virtual uint64_t BytesOnDisk() = 0;

  // Runs statements without parameters and ignores their rows. Throws Error.
  virtual void Execute(const std::string& script) = 0;
  // Prepares one of Cairn's own statements. Each connection compiles a statement once. Throws
  // Error(kMapDamaged) if the database does not have the tables of a map.
  virtual Statement Prepare(std::string_view sql) = 0;

  // Returns the column `bytes` of the row with this key; nothing if there is no such row.
  virtual std::optional<LargeVector<uint8_t>> ReadBytes(const char* table, const char* key_column,
                                                        int64_t key) = 0;
};

}  // namespace cairn::db

#endif  // CAIRN_STORAGE_DATABASE_CONNECTION_H_
