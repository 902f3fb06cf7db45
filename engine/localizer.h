// Localizes a query: calls the stages prior, tiles, matching, voting, pose, refinement in order.
#ifndef CAIRN_ENGINE_LOCALIZER_H_
#define CAIRN_ENGINE_LOCALIZER_H_

#include <memory>

#include "engine/localizer_options.h"
#include "engine/query/localize_query.h"
#include "engine/query/localize_result.h"
#include "storage/map/map_store.h"
#include "storage/map/tile_cache.h"

namespace cairn {

// Answers queries against one map. Safe to call from any thread. Each call pins the map version
// that is current when the call starts.
class Localizer {
 public:
  // Other objects may share `store` and `cache`. The cache identifies tiles by the digest of their
  // payload only, so it must hold only tiles that were made with the same options.matching.index.
  // Validates the options.
  Localizer(std::shared_ptr<const MapStore> store, std::shared_ptr<TileCache> cache,
            const LocalizerOptions& options);
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

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_LOCALIZER_H_
