// A limit for files of other programs.
#ifndef CAIRN_STORAGE_DATABASE_SQLITE_LIMIT_VALUES_H_
#define CAIRN_STORAGE_DATABASE_SQLITE_LIMIT_VALUES_H_

#include "storage/database/sqlite/connection.h"

namespace cairn::sqlite {

// From now on, the connection refuses rows, texts and blobs of more bytes.
void LimitValues(Connection* connection, int max_bytes);

}  // namespace cairn::sqlite

#endif  // CAIRN_STORAGE_DATABASE_SQLITE_LIMIT_VALUES_H_
