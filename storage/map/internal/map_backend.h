// The operations that differ between a file and PostgreSQL; private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_MAP_BACKEND_H_
#define CAIRN_STORAGE_MAP_INTERNAL_MAP_BACKEND_H_

#include <memory>
#include <optional>
#include <string>

#include "storage/database/connection.h"
#include "storage/map/map_store.h"

namespace cairn {

struct MapHead {
  MapVersion version{};
  bool is_stale = false;  // PostgreSQL is silent, so there may be a newer version.
  // Number of times that PostgreSQL has lost versions (postgres::HeadWatcher). What was cached
  // before the last time is void.
  int num_losses = 0;
};

// A connection in a write transaction. At most one exists per map, across processes. The destructor
// rolls back unless committed.
class WriteTransaction {
 public:
  virtual ~WriteTransaction() = default;
  virtual db::Connection* connection() = 0;
  virtual void Commit() = 0;
};

// Safe to call from any thread.
class MapBackend {
 public:
  virtual ~MapBackend() = default;

  virtual const std::string& name() const = 0;  // As db::Connection::name.
  // Returns the latest version if it is known without a read.
  virtual std::optional<MapHead> KnownHead() const = 0;

  // Lends a connection for reading. Throws Error(kUnavailable) if none is free in time.
  virtual std::unique_ptr<db::Connection> Take(ReadDeadline deadline) = 0;
  virtual void GiveBack(std::unique_ptr<db::Connection> connection) = 0;

  // Throws Error(kConflict) if another update runs.
  virtual std::unique_ptr<WriteTransaction> BeginUpdate() = 0;

  virtual MapFileState FileState() const = 0;
  virtual std::string LogPath() const = 0;
};

// Throws as MapStore::Open.
std::unique_ptr<MapBackend> OpenBackend(const std::string& path, OpenMode mode);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_MAP_BACKEND_H_
