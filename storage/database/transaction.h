// A read transaction that ends with its scope.
#ifndef CAIRN_STORAGE_DATABASE_TRANSACTION_H_
#define CAIRN_STORAGE_DATABASE_TRANSACTION_H_

#include "storage/database/connection.h"

namespace cairn::db {

// All statements on the connection read one state of the database. The destructor ends the
// transaction and never throws. The connection must outlive the object.
class ReadTransaction {
 public:
  explicit ReadTransaction(Connection* connection);
  ~ReadTransaction();
  ReadTransaction(const ReadTransaction&) = delete;
  ReadTransaction& operator=(const ReadTransaction&) = delete;

 private:
  Connection* connection_;
};

}  // namespace cairn::db

#endif  // CAIRN_STORAGE_DATABASE_TRANSACTION_H_
