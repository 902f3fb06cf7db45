#include "storage/database/sqlite/transaction.h"

#include <sqlite3.h>

namespace cairn::sqlite {

Transaction::Transaction(Connection* connection, Kind kind) : connection_(connection) {
  connection->Execute(kind == Kind::kImmediate ? "BEGIN IMMEDIATE" : "BEGIN DEFERRED");
}

Transaction::~Transaction() {
  // After a failure such as a full disk, SQLite may have rolled back already.
  if (connection_ != nullptr && sqlite3_get_autocommit(connection_->handle()) == 0) {
    sqlite3_exec(connection_->handle(), "ROLLBACK", nullptr, nullptr, nullptr);
  }
}

void Transaction::Commit() {
  connection_->Execute("COMMIT");
  connection_ = nullptr;
}

}  // namespace cairn::sqlite
