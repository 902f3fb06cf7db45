// Tells which columns a COLMAP database has, which depends on COLMAP's version. Private to
// ingest/colmap.
#ifndef CAIRN_INGEST_COLMAP_COLMAP_COLUMNS_H_
#define CAIRN_INGEST_COLMAP_COLMAP_COLUMNS_H_

#include <string_view>

#include "storage/database/sqlite/connection.h"

namespace cairn {

inline bool HasColumn(sqlite::Connection* connection, std::string_view table,
                      std::string_view column) {
  sqlite::Statement statement =
      connection->Prepare("SELECT COUNT(*) FROM pragma_table_info(?) WHERE name = ?");
  statement.Bind(table, column);
  return statement.Step() && statement.Int64(0) > 0;
}

}  // namespace cairn

#endif  // CAIRN_INGEST_COLMAP_COLMAP_COLUMNS_H_
