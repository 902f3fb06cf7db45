// Builds what queries in a hurry have left of the indices of tiles.
#ifndef CAIRN_ENGINE_TILES_INDEX_FINISHER_H_
#define CAIRN_ENGINE_TILES_INDEX_FINISHER_H_

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "engine/shared_workers.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// One thread, started when there is something to do for the first time. Safe to use from any
// thread. Its end waits for the part that is being built and leaves the rest.
class IndexFinisher {
 public:
  // While it builds, the thread counts as a caller of `workers`, which must outlive this.
  explicit IndexFinisher(SharedWorkers* workers) : workers_(workers) {}

  // Has a tile's index completed, after those of earlier calls; not if the cache and all queries
  // have dropped the tile by then. Does not wait.
  void Add(const std::shared_ptr<const SearchableTile>& tile);

 private:
  void Work(std::stop_token stop);
  void Complete(const SearchableTile& tile, const std::stop_token& stop);

  SharedWorkers* workers_;
  std::mutex mutex_;  // Of the next three.
  std::condition_variable_any has_tiles_;
  std::deque<std::weak_ptr<const SearchableTile>> tiles_;
  std::jthread thread_;  // The last member, so that it ends before the others do.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_INDEX_FINISHER_H_
