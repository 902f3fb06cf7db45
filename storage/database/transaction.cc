#include "storage/database/transaction.h"

#include <exception>

namespace cairn::db {

ReadTransaction::ReadTransaction(Connection* connection) : connection_(connection) {
  connection->Execute(connection->dialect() == Dialect::kSqlite
                          ? "BEGIN DEFERRED"
                          : "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY");
}

ReadTransaction::~ReadTransaction() {
  try {
    connection_->Execute("ROLLBACK");
  } catch (const std::exception&) {
    // The connection is broken, and with it the transaction has ended.
  }
}

}  // namespace cairn::db
