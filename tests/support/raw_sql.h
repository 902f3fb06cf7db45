// Runs SQL that bypasses the checks of MapStore, for tests that damage maps.
#ifndef CAIRN_TESTS_SUPPORT_RAW_SQL_H_
#define CAIRN_TESTS_SUPPORT_RAW_SQL_H_

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <string>

#include "storage/inspection/register.h"
#ifdef CAIRN_WITH_POSTGRES
#include "storage/database/postgres/server.h"
#endif

namespace cairn::testing {

// Runs SQL in a database; a file is created if it does not exist. No foreign
// keys are enforced. A map on a server needs CAIRN_WITH_POSTGRES.
inline void ExecuteRaw(const std::string& path, const std::string& sql) {
#ifdef CAIRN_WITH_POSTGRES
  if (path.starts_with("postgresql:")) {
    postgres::Server(path)
        .Connect(postgres::Use::kWrite, {})
        ->Execute("SET session_replication_role = replica; " + sql);
    return;
  }
#endif
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  ASSERT_EQ(inspection::RegisterInspection(db), SQLITE_OK);
  char* error = nullptr;
  ASSERT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
  ASSERT_EQ(sqlite3_close(db), SQLITE_OK);
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_RAW_SQL_H_
