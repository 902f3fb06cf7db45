// Opens the database of a map or reports why the file cannot be opened as a map. Private to
// storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_MAP_FILE_H_
#define CAIRN_STORAGE_MAP_INTERNAL_MAP_FILE_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "storage/database/sqlite/connection.h"

namespace cairn {

// The format version that this code writes, and the oldest reader that can read it. See
// docs/formats/map_v1.md.
inline constexpr int64_t kMapFormatVersion = 1;
inline constexpr int64_t kOldestReaderVersion = 1;

// Creates the file with an empty map of version 1. If `fill` is set, calls it with the name of the
// map, which is temporary; the file gets the name `path` once `fill` returns, so a process that
// dies leaves nothing at `path`. Throws Error(kConflict) if the file exists or another process
// creates it, and Error(kIo) if the file cannot be created.
void CreateMapFile(const std::string& path, const std::function<void(const std::string&)>& fill);

// Opens a connection for reading, after the checks that MapStore::Open promises. Changes *access
// from kReadOnly to kImmutable if the directory is not writable and no write-ahead log is left.
std::unique_ptr<sqlite::Connection> OpenMapFile(const std::string& path, sqlite::Access* access);

// Opens another connection for reading a map that has already passed the checks.
std::unique_ptr<sqlite::Connection> ReopenMapFile(const std::string& path, sqlite::Access access);

// Opens a connection for one update. Does not wait for locks.
std::unique_ptr<sqlite::Connection> OpenMapFileForUpdate(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_MAP_FILE_H_
