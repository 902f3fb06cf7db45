// A map's SQLite file as a db::Connection. Private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_SQLITE_DATABASE_H_
#define CAIRN_STORAGE_MAP_INTERNAL_SQLITE_DATABASE_H_

#include <memory>
#include <string>

#include "storage/database/connection.h"
#include "storage/database/sqlite/connection.h"

namespace cairn {

class SqliteDatabase : public db::Connection {
 public:
  explicit SqliteDatabase(std::unique_ptr<sqlite::Connection> connection)
      : connection_(std::move(connection)) {}

  sqlite::Connection* connection() { return connection_.get(); }

  const std::string& name() const override { return connection_->path(); }
  db::Dialect dialect() const override { return db::Dialect::kSqlite; }
  uint64_t BytesOnDisk() override;
  void Execute(const std::string& script) override { connection_->Execute(script); }
  db::Statement Prepare(std::string_view sql) override;
  // Needs a rowid table whose key is the rowid.
  std::optional<LargeVector<uint8_t>> ReadBytes(const char* table, const char* key_column,
                                                int64_t key) override;

 private:
  std::unique_ptr<sqlite::Connection> connection_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_SQLITE_DATABASE_H_
