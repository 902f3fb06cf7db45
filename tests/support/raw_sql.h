// Runs SQL that bypasses the checks of MapStore, for tests that damage maps.
#ifndef CAIRN_TESTS_SUPPORT_RAW_SQL_H_
#define CAIRN_TESTS_SUPPORT_RAW_SQL_H_

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <string>

#include "storage/inspection/register.h"

namespace cairn::testing {

// Runs SQL in a database, which is created if it does not exist. Foreign keys are not enforced.
inline void ExecuteRaw(const std::string& path, const std::string& sql) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  ASSERT_EQ(inspection::RegisterInspection(db), SQLITE_OK);
  char* error = nullptr;
  ASSERT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
  ASSERT_EQ(sqlite3_close(db), SQLITE_OK);
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_RAW_SQL_H_
