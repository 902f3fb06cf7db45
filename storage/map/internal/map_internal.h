// The implementation structs of MapSnapshot and MapUpdate. Private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_MAP_INTERNAL_H_
#define CAIRN_STORAGE_MAP_INTERNAL_MAP_INTERNAL_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "storage/map/internal/head_writer.h"
#include "storage/map/internal/open_map.h"
#include "storage/map/map_store.h"

namespace cairn {

struct MapSnapshot::Impl {
  Impl(std::shared_ptr<OpenMap> open_map, ReadDeadline read_deadline);

  std::shared_ptr<OpenMap> map;
  ReadDeadline deadline;
  MapHead head;
  std::shared_ptr<VersionCache> cache;

  // Calls read(connection, arguments..., version) with a borrowed connection.
  template <typename Read, typename... Arguments>
  auto Call(const Read& read, const Arguments&... arguments) const {
    return map->Call(deadline, [&](db::Connection* connection) {
      return read(connection, arguments..., head.version);
    });
  }

  // Returns the tiles that the version has of these, in any order. `ids` are in ascending order.
  // All tiles that the cache lacks are read in one call.
  std::vector<FoundTile> Tiles(const std::vector<int64_t>& ids) const;
};

// Holds the map's write transaction.
struct MapUpdate::Impl {
  explicit Impl(std::unique_ptr<WriteTransaction> write_transaction);

  db::Connection* connection() { return transaction->connection(); }

  std::unique_ptr<WriteTransaction> transaction;
  bool is_published = false;
  HeadWriter head;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_MAP_INTERNAL_H_
