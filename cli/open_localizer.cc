#include "cli/open_localizer.h"

namespace cairn {

OpenedMap OpenLocalizer(const std::string& map_path, const LocalizerOptions& options,
                        size_t cache_bytes) {
  OpenedMap map;
  map.store = std::make_shared<const MapStore>(MapStore::Open(map_path, OpenMode::kReadOnly));
  map.cache = std::make_shared<TileCache>(cache_bytes);
  map.localizer = std::make_unique<Localizer>(map.store, map.cache, options);
  return map;
}

}  // namespace cairn
