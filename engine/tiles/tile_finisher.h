// Loads in the background what queries had no time to load.
#ifndef CAIRN_ENGINE_TILES_TILE_FINISHER_H_
#define CAIRN_ENGINE_TILES_TILE_FINISHER_H_

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

#include "core/shared_workers.h"
#include "engine/query/query_context.h"
#include "engine/tiles/map_tiles.h"
#include "engine/tiles/tile_cache.h"
#include "engine/tiles/tiles_options.h"

namespace cairn {

// Uses one thread, which starts with the first call of Add. Safe to use from any thread. The
// destructor waits for the tile or the part of an index that is being built, and skips the rest.
class TileFinisher {
 public:
  // Number of queued regions. If there are more, the oldest is dropped; a query that needs it loads
  // it.
  static constexpr size_t kMaxWaiting = 64;

  // Calls its argument with the latest tiles of a map.
  using ReadLatestTiles = std::function<void(const std::function<void(const MapTiles&)>& read)>;

  // Loads as FetchTiles does with these arguments, which must outlive the object. While it loads,
  // the thread counts as a caller of `workers`.
  TileFinisher(ReadLatestTiles read_latest, TileCache* cache, const TilesOptions* options,
               SharedWorkers* workers);

  // Queues the loading of a region's tiles and the completion of their indices, after earlier
  // calls. Does not wait.
  void Add(const SearchRegion& region);

 private:
  void Work(std::stop_token stop);
  void Load(const SearchRegion& region, const std::stop_token& stop);

  const ReadLatestTiles read_latest_;
  TileCache* cache_;
  const TilesOptions* options_;
  SharedWorkers* workers_;
  std::mutex mutex_;  // Guards the next three members.
  std::condition_variable_any has_regions_;
  std::deque<SearchRegion> regions_;
  // The last member, so that the thread ends before the others are destroyed.
  std::jthread thread_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_TILE_FINISHER_H_
