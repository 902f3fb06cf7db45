// Localizes a query: calls the stages prior and tiles (both in engine/tiles), matching, voting,
// pose, refinement and answer in order. A query without a rough position goes through engine/places
// first.
#ifndef CAIRN_ENGINE_LOCALIZER_H_
#define CAIRN_ENGINE_LOCALIZER_H_

#include <cstddef>
#include <memory>
#include <string>

#include "engine/localizer_options.h"
#include "engine/query/localize_query.h"
#include "engine/query/localize_result.h"
#include "engine/tiles/map_tiles.h"
#include "engine/tiles/tile_cache.h"
#include "storage/map/map_store.h"

namespace cairn {

// Answers queries against one map, whose tiles it keeps in memory. Safe to call from any thread.
// Each call pins the map version that is current when the call starts.
class Localizer {
 public:
  // Opens a map file, or a map on a PostgreSQL server by its URL, read-only. Throws as
  // MapStore::Open and LocalizerOptions::Validate.
  static Localizer Open(const std::string& path_or_url, const LocalizerOptions& options = {},
                        size_t cache_bytes = kDefaultCacheBytes);

  // Answers against an open map. Throws as LocalizerOptions::Validate, and Error(kInvalidArgument)
  // if `cache_bytes` is 0.
  Localizer(std::shared_ptr<const MapStore> map, const LocalizerOptions& options,
            size_t cache_bytes = kDefaultCacheBytes);
  // Shares the cache of another localizer. Throws Error(kInvalidArgument) if the cache does not
  // index tiles as options.matching.index says.
  Localizer(std::shared_ptr<const MapStore> map, const LocalizerOptions& options,
            std::shared_ptr<TileCache> cache);
  // Answers against tiles that need not be those of a map on disk. `tiles` must outlive the
  // localizer. Shares the cache, as above: of tiles with different content, records must have
  // different digests.
  Localizer(const MapTiles& tiles, const LocalizerOptions& options,
            std::shared_ptr<TileCache> cache);
  Localizer(Localizer&&) noexcept;
  ~Localizer();

  // If the query has no answer, the result states the reason. Throws Error(kBadInput) for an
  // invalid query (see LocalizeQuery::Validate; also a wrong descriptor dimension or codec), and
  // Error(kMapDamaged) if a tile does not decode, and Error(kUnavailable) if the map's server does
  // not answer by the query's deadline and tiles are missing.
  LocalizeResult Localize(const LocalizeQuery& query) const;
  // Answers against a given version of the store's map, whatever is published meanwhile. Throws as
  // Localize, and Error(kUnavailable) if the version was pruned.
  LocalizeResult LocalizeIn(const MapSnapshot& map, const LocalizeQuery& query) const;

  const LocalizerOptions& options() const;
  const MapStore& map() const;  // Of a localizer with a map.
  const std::shared_ptr<TileCache>& cache() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_LOCALIZER_H_
