#include "engine/tiles/index_finisher.h"

#include <exception>
#include <utility>

namespace cairn {

void IndexFinisher::Add(const std::shared_ptr<const SearchableTile>& tile) {
  {
    const std::lock_guard lock(mutex_);
    tiles_.push_back(tile);
    if (!thread_.joinable()) {
      thread_ = std::jthread([this](std::stop_token stop) { Work(std::move(stop)); });
    }
  }
  has_tiles_.notify_one();
}

void IndexFinisher::Work(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  while (has_tiles_.wait(lock, stop, [this] { return !tiles_.empty(); }) &&
         !stop.stop_requested()) {
    const std::shared_ptr<const SearchableTile> tile = tiles_.front().lock();
    tiles_.pop_front();
    if (tile != nullptr) {
      lock.unlock();
      Complete(*tile, stop);
      lock.lock();
    }
  }
}

void IndexFinisher::Complete(const SearchableTile& tile, const std::stop_token& stop) {
  const SharedWorkers::Caller caller(workers_);
  try {
    while (!tile.index().is_complete() && !stop.stop_requested()) {
      tile.index().BuildPart();
    }
  } catch (const std::exception&) {
    // Out of memory: there is nobody to tell here. The next query that needs the rest will be told.
  }
}

}  // namespace cairn
