// Installs and verifies the schema of a map in PostgreSQL by numbered migrations.
#ifndef CAIRN_STORAGE_DATABASE_POSTGRES_SCHEMA_H_
#define CAIRN_STORAGE_DATABASE_POSTGRES_SCHEMA_H_

#include <string>

#include "storage/database/postgres/postgres_connection.h"

namespace cairn::postgres {

// Creates the schema `cairn` in the open transaction. Adds PostGIS to the database if it is
// missing. Throws Error(kConflict) if the database has a map, Error(kUnavailable) if the server has
// no PostGIS, Error(kIo) if the role may not create the schema or add PostGIS.
void InstallSchema(PostgresConnection* connection);

// Deletes the map with everything in it.
void DropSchema(PostgresConnection* connection);

// Throws Error(kNotFound) if the database has no map, Error(kConflict) if the map has other
// migrations than this program, Error(kIo) if the role may not read the map.
void RequireSchema(PostgresConnection* connection);

// Throws Error(kIo) unless the role may publish versions.
void RequireMayWrite(PostgresConnection* connection);

}  // namespace cairn::postgres

#endif  // CAIRN_STORAGE_DATABASE_POSTGRES_SCHEMA_H_
