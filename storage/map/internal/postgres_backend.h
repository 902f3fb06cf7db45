// A map in a PostgreSQL database; private to storage. In a build without libpq, all functions
// except IsServerAddress throw Error(kUnavailable).
#ifndef CAIRN_STORAGE_MAP_INTERNAL_POSTGRES_BACKEND_H_
#define CAIRN_STORAGE_MAP_INTERNAL_POSTGRES_BACKEND_H_

#include <memory>
#include <string>

#include "storage/map/internal/map_backend.h"

namespace cairn {

// Returns true for "postgresql://..." and "postgres://...".
bool IsServerAddress(const std::string& path);

// Throws as MapStore::Open.
std::unique_ptr<MapBackend> OpenPostgresMap(const std::string& url, OpenMode mode);

// Creates the schema `cairn` with an empty map of version 1, in one transaction. Throws
// Error(kConflict) if the database has a map.
void CreatePostgresMap(const std::string& url);

// Deletes the map that the caller has just created.
void DropPostgresMap(const std::string& url);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_POSTGRES_BACKEND_H_
