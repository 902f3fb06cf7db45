#include "storage/database/sqlite/limit_values.h"

#include <sqlite3.h>

namespace cairn::sqlite {

void LimitValues(Connection* connection, int max_bytes) {
  sqlite3_limit(connection->handle(), SQLITE_LIMIT_LENGTH, max_bytes);
}

}  // namespace cairn::sqlite
