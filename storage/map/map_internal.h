// What is behind MapSnapshot and MapUpdate; private to storage.
#ifndef CAIRN_STORAGE_MAP_MAP_INTERNAL_H_
#define CAIRN_STORAGE_MAP_MAP_INTERNAL_H_

#include <memory>
#include <optional>

#include "storage/map/map_store.h"
#include "storage/map/reader_pool.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/transaction.h"

namespace cairn {

// Borrows a connection of the pool and holds a read transaction on it.
struct MapSnapshot::Impl {
  explicit Impl(std::shared_ptr<ReaderPool> reader_pool);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  std::shared_ptr<ReaderPool> pool;
  std::unique_ptr<sqlite::Connection> connection;
  std::optional<sqlite::Transaction> transaction;  // Ends before the connection is given back.
  MapVersion version{};
};

// Owns a connection and holds the write transaction of the map on it.
struct MapUpdate::Impl {
  explicit Impl(const std::string& path);

  std::unique_ptr<sqlite::Connection> connection;
  std::optional<sqlite::Transaction> transaction;  // Nothing once published.
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_MAP_INTERNAL_H_
