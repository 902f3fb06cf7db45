// The implementation structs of MapSnapshot and MapUpdate. Private to storage.
#ifndef CAIRN_STORAGE_MAP_MAP_INTERNAL_H_
#define CAIRN_STORAGE_MAP_MAP_INTERNAL_H_

#include <memory>
#include <optional>

#include "storage/map/head_writer.h"
#include "storage/map/map_store.h"
#include "storage/map/reader_pool.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/transaction.h"

namespace cairn {

// Borrows a connection from the pool and holds a read transaction on the connection.
struct MapSnapshot::Impl {
  explicit Impl(std::shared_ptr<ReaderPool> reader_pool);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  std::shared_ptr<ReaderPool> pool;
  std::unique_ptr<sqlite::Connection> connection;
  std::optional<sqlite::Transaction> transaction;  // Ends before the connection is returned.
  MapVersion version{};
};

// Owns a connection and holds the map's write transaction on the connection.
struct MapUpdate::Impl {
  explicit Impl(const std::string& path);

  std::unique_ptr<sqlite::Connection> connection;
  std::optional<sqlite::Transaction> transaction;  // Empty once published.
  std::optional<HeadWriter> head;                  // Set by the constructor.
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_MAP_INTERNAL_H_
