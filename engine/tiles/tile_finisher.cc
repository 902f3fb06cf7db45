#include "engine/tiles/tile_finisher.h"

#include <exception>
#include <utility>

#include "engine/query/localize_result.h"
#include "engine/tiles/fetch_tiles.h"

namespace cairn {

TileFinisher::TileFinisher(const MapStore* store, TileCache* cache, const TilesOptions* options,
                           const IndexOptions* index_options, SharedWorkers* workers)
    : store_(store),
      cache_(cache),
      options_(options),
      index_options_(index_options),
      workers_(workers) {}

void TileFinisher::Add(const SearchRegion& region) {
  {
    const std::lock_guard lock(mutex_);
    if (regions_.size() == kMaxWaiting) {
      regions_.pop_front();
    }
    regions_.push_back(region);
    if (!thread_.joinable()) {
      thread_ = std::jthread([this](std::stop_token stop) { Work(std::move(stop)); });
    }
  }
  has_regions_.notify_one();
}

void TileFinisher::Work(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  while (has_regions_.wait(lock, stop, [this] { return !regions_.empty(); }) &&
         !stop.stop_requested()) {
    SearchRegion region = std::move(regions_.front());
    regions_.pop_front();
    lock.unlock();
    Load(std::move(region), stop);
    lock.lock();
  }
}

void TileFinisher::Load(SearchRegion region, const std::stop_token& stop) {
  const SharedWorkers::Caller caller(workers_);
  try {
    StageCounters counters;
    FetchTiles(store_->Snapshot(), cache_, *options_, *index_options_, &region, &counters,
               [&stop] { return stop.stop_requested(); });
  } catch (const std::exception&) {
    // A damaged tile or lack of memory cannot be reported from here. The next query that needs the
    // missing part reports it.
  }
}

}  // namespace cairn
