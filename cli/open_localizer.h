// A map opened for queries in this process.
#ifndef CAIRN_CLI_OPEN_LOCALIZER_H_
#define CAIRN_CLI_OPEN_LOCALIZER_H_

#include <cstddef>
#include <memory>
#include <string>

#include "engine/localizer.h"
#include "storage/map/map_store.h"
#include "storage/map/tile_cache.h"

namespace cairn {

inline constexpr size_t kDefaultCacheBytes = size_t{1} << 30;

struct OpenedMap {
  std::shared_ptr<const MapStore> store;
  std::shared_ptr<TileCache> cache;
  std::unique_ptr<Localizer> localizer;
};

// Opens the map read-only. Throws as MapStore::Open.
OpenedMap OpenLocalizer(const std::string& map_path, const LocalizerOptions& options,
                        size_t cache_bytes = kDefaultCacheBytes);

}  // namespace cairn

#endif  // CAIRN_CLI_OPEN_LOCALIZER_H_
