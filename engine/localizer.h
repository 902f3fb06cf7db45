// One query, one pose: calls the stages prior, tiles, matching, voting, pose, refinement in order.
#ifndef CAIRN_ENGINE_LOCALIZER_H_
#define CAIRN_ENGINE_LOCALIZER_H_

#include <memory>

#include "engine/localizer_options.h"
#include "engine/query/localize_query.h"
#include "engine/query/localize_result.h"
#include "storage/map/map_store.h"
#include "storage/map/tile_cache.h"

namespace cairn {

// Answers queries against one map. Safe to call from any thread; each call pins the map version
// that is current when it starts.
class Localizer {
 public:
  // `store` and `cache` are shared with whoever else uses them; a cache must hold tiles of this
  // store made with the same options.matching.index, as it knows them by payload only. Validates
  // the options.
  Localizer(std::shared_ptr<const MapStore> store, std::shared_ptr<TileCache> cache,
            const LocalizerOptions& options);
  ~Localizer();

  // A query without an answer is a result with a reason. Throws Error(kBadInput) on a query that
  // makes no sense (see LocalizeQuery::Validate, descriptor dimension, codec), Error(kMapDamaged)
  // if a tile does not decode.
  LocalizeResult Localize(const LocalizeQuery& query) const;

  const LocalizerOptions& options() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_LOCALIZER_H_
