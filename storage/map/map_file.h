// Opens the database of a map, or says what is wrong with the file; private to storage.
#ifndef CAIRN_STORAGE_MAP_MAP_FILE_H_
#define CAIRN_STORAGE_MAP_MAP_FILE_H_

#include <cstdint>
#include <memory>
#include <string>

#include "storage/sqlite/connection.h"

namespace cairn {

// The format this code writes, and with it the oldest reader of what it writes.
// docs/formats/map_v1.md.
inline constexpr int64_t kMapFormatVersion = 1;
inline constexpr int64_t kOldestReaderVersion = 1;

// Makes the file with an empty map, version 1. Throws Error(kConflict) if the file exists,
// Error(kIo) if it cannot be made.
void CreateMapFile(const std::string& path);

// A connection for reading, after the checks that MapStore::Open promises. Turns kReadOnly into
// kImmutable where the directory cannot be written and no write-ahead log is left.
std::unique_ptr<sqlite::Connection> OpenMapFile(const std::string& path, sqlite::Access* access);

// Another connection for reading a map that passed the checks already.
std::unique_ptr<sqlite::Connection> ReopenMapFile(const std::string& path, sqlite::Access access);

// A connection for one update; waits for no lock.
std::unique_ptr<sqlite::Connection> OpenMapFileForUpdate(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_MAP_FILE_H_
