#include "engine/tiles/tile_finisher.h"

#include <exception>
#include <utility>

#include "engine/tiles/fetch_tiles.h"

namespace cairn {

TileFinisher::TileFinisher(ReadLatestTiles read_latest, TileCache* cache,
                           const TilesOptions* options, SharedWorkers* workers)
    : read_latest_(std::move(read_latest)), cache_(cache), options_(options), workers_(workers) {}

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
    const SearchRegion region = std::move(regions_.front());
    regions_.pop_front();
    lock.unlock();
    Load(region, stop);
    lock.lock();
  }
}

void TileFinisher::Load(const SearchRegion& region, const std::stop_token& stop) {
  const SharedWorkers::Caller caller(workers_);
  try {
    read_latest_([&](const MapTiles& map) {
      FetchTiles(map, region, *options_, cache_, [&stop] { return stop.stop_requested(); });
    });
  } catch (const std::exception&) {
    // A damaged tile or lack of memory cannot be reported from here. The next query that needs the
    // missing part reports it.
  }
}

}  // namespace cairn
