// Loads what queries in a hurry have left of the map around them.
#ifndef CAIRN_ENGINE_TILES_TILE_FINISHER_H_
#define CAIRN_ENGINE_TILES_TILE_FINISHER_H_

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <stop_token>
#include <thread>

#include "core/shared_workers.h"
#include "engine/index/index_options.h"
#include "engine/query/query_context.h"
#include "engine/tiles/tiles_options.h"
#include "storage/map/map_store.h"
#include "storage/map/tile_cache.h"

namespace cairn {

// One thread, started when there is something to do for the first time. Safe to use from any
// thread. Its end waits for the tile or the part of an index that is being built and leaves the
// rest.
class TileFinisher {
 public:
  // Regions that wait; of more the oldest are forgotten, and a query that needs them loads them.
  static constexpr size_t kMaxWaiting = 64;

  // Loads as FetchTiles would with these arguments. All of them must outlive this. While it loads,
  // the thread counts as a caller of `workers`.
  TileFinisher(const MapStore* store, TileCache* cache, const TilesOptions* options,
               const IndexOptions* index_options, SharedWorkers* workers);

  // Has the tiles of a region loaded and their indices completed, after those of earlier calls.
  // Does not wait.
  void Add(const SearchRegion& region);

 private:
  void Work(std::stop_token stop);
  void Load(SearchRegion region, const std::stop_token& stop);

  const MapStore* store_;
  TileCache* cache_;
  const TilesOptions* options_;
  const IndexOptions* index_options_;
  SharedWorkers* workers_;
  std::mutex mutex_;  // Of the next three.
  std::condition_variable_any has_regions_;
  std::deque<SearchRegion> regions_;
  std::jthread thread_;  // The last member, so that it ends before the others do.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_TILE_FINISHER_H_
