// Entry point of the loadable extension: `.load ./cairn_sqlite` in the sqlite3 shell.
#include <sqlite3ext.h>

#include "storage/inspection/register.h"

SQLITE_EXTENSION_INIT1

extern "C" __attribute__((visibility("default"))) int sqlite3_cairnsqlite_init(
    sqlite3* db, char** /*error*/, const sqlite3_api_routines* api) {
  SQLITE_EXTENSION_INIT2(api);
  return cairn::inspection::RegisterInspection(db);
}
