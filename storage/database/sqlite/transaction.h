// A transaction that ends with its scope.
#ifndef CAIRN_STORAGE_DATABASE_SQLITE_TRANSACTION_H_
#define CAIRN_STORAGE_DATABASE_SQLITE_TRANSACTION_H_

#include "storage/database/sqlite/connection.h"

namespace cairn::sqlite {

// Rolls back on destruction unless committed; rolling back never throws. The connection must
// outlive the transaction. Used by the thread that uses the connection.
class Transaction {
 public:
  enum class Kind {
    kDeferred,   // Takes its snapshot at the first read.
    kImmediate,  // Takes the write lock immediately or throws Error(kConflict).
  };

  Transaction(Connection* connection, Kind kind);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  void Commit();

 private:
  Connection* connection_;
};

}  // namespace cairn::sqlite

#endif  // CAIRN_STORAGE_DATABASE_SQLITE_TRANSACTION_H_
