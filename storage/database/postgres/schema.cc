#include "storage/database/postgres/schema.h"

#include <fmt/format.h>

#include <iterator>
#include <string_view>

#include "core/error.h"
#include "sql/postgres_schema.h"

namespace cairn::postgres {
namespace {

struct Migration {
  const char* name;
  std::string_view sql;
};

constexpr Migration kMigrations[] = {
    {"0001_map", sql::k_0001_map_sql},
};

// Returns the result of a query for one boolean.
bool Holds(PostgresConnection* connection, const char* sql) {
  db::Statement row = connection->Prepare(sql);
  return row.Step() && row.Int64(0) != 0;
}

bool HasMap(PostgresConnection* connection) {
  return Holds(connection, "SELECT to_regclass('cairn.cairn_migrations') IS NOT NULL");
}

void RequirePostgis(PostgresConnection* connection) {
  if (Holds(connection, "SELECT count(*) > 0 FROM pg_extension WHERE extname = 'postgis'")) {
    return;
  }
  if (!Holds(connection,
             "SELECT count(*) > 0 FROM pg_available_extensions WHERE name = 'postgis'")) {
    throw Error(ErrorCode::kUnavailable,
                connection->name() +
                    ": the server has no PostGIS; install it there (Debian: "
                    "postgresql-15-postgis-3)");
  }
  try {
    connection->Execute("CREATE EXTENSION postgis");
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kIo) {
      throw;
    }
    throw Error(ErrorCode::kIo, connection->name() +
                                    ": the database has no PostGIS, and this role may not add it; "
                                    "let a superuser run CREATE EXTENSION postgis in it");
  }
}

}  // namespace

void InstallSchema(PostgresConnection* connection) {
  if (HasMap(connection)) {
    throw Error(ErrorCode::kConflict,
                connection->name() +
                    ": the database has a map already; if it is the empty rest of a copy that was "
                    "killed, run DROP SCHEMA cairn CASCADE there");
  }
  RequirePostgis(connection);
  int64_t number = 0;
  for (const Migration& migration : kMigrations) {
    connection->Execute(std::string(migration.sql));
    connection->Prepare("INSERT INTO cairn.cairn_migrations (migration, name) VALUES (?, ?)")
        .Bind(++number, std::string_view(migration.name))
        .Run();
  }
}

void DropSchema(PostgresConnection* connection) {
  connection->Execute("DROP SCHEMA cairn CASCADE");
}

void RequireSchema(PostgresConnection* connection) {
  if (!HasMap(connection)) {
    throw Error(ErrorCode::kNotFound, connection->name() +
                                          ": the database has no map; make one with `cairn init`, "
                                          "or correct the name of the database");
  }
  if (!Holds(connection,
             "SELECT has_schema_privilege('cairn', 'USAGE') AND "
             "has_table_privilege('cairn.cairn_versions', 'SELECT')")) {
    throw Error(ErrorCode::kIo, connection->name() +
                                    ": this role may not read the map; let the owner of the map "
                                    "run GRANT cairn_reader TO the role");
  }
  db::Statement row =
      connection->Prepare("SELECT coalesce(max(migration), 0) FROM cairn.cairn_migrations");
  row.Step();
  constexpr auto kNewest = static_cast<int64_t>(std::size(kMigrations));
  if (row.Int64(0) != kNewest) {
    throw Error(ErrorCode::kConflict,
                fmt::format("{}: the database has schema {}, this program reads schema {}; use {}",
                            connection->name(), row.Int64(0), kNewest,
                            row.Int64(0) > kNewest ? "a newer Cairn"
                                                   : "the Cairn that made it, and `cairn copy` the "
                                                     "map through a file"));
  }
}

void RequireMayWrite(PostgresConnection* connection) {
  if (!Holds(connection, "SELECT has_table_privilege('cairn.cairn_versions', 'INSERT')")) {
    throw Error(ErrorCode::kIo, connection->name() +
                                    ": this role may only read the map; connect as a role with "
                                    "GRANT cairn_builder");
  }
}

}  // namespace cairn::postgres
