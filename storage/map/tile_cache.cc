#include "storage/map/tile_cache.h"

#include <future>
#include <list>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/error.h"

namespace cairn {

using CachedTilePtr = std::shared_ptr<const CachedTile>;

struct TileCache::Impl {
  struct Entry {
    CachedTilePtr tile;
    size_t bytes = 0;
    std::list<std::string>::iterator position;  // In `recently_used`.
  };

  mutable std::mutex mutex;
  std::list<std::string> recently_used;  // The front is the most recently used.
  std::unordered_map<std::string, Entry> entries;
  std::unordered_map<std::string, std::shared_future<CachedTilePtr>> loading;
  TileCacheStats stats;

  // Keeps the value if it fits. Returns the evicted values, so that the caller destroys them
  // without holding the lock.
  std::vector<CachedTilePtr> Insert(const std::string& digest, const CachedTilePtr& tile,
                                    size_t bytes) {
    std::vector<CachedTilePtr> evicted;
    if (bytes > stats.max_bytes) {
      return evicted;
    }
    while (stats.bytes + bytes > stats.max_bytes) {
      const auto oldest = entries.find(recently_used.back());
      stats.bytes -= oldest->second.bytes;
      evicted.push_back(std::move(oldest->second.tile));
      entries.erase(oldest);
      recently_used.pop_back();
      ++stats.num_evictions;
    }
    recently_used.push_front(digest);
    entries[digest] = {tile, bytes, recently_used.begin()};
    stats.bytes += bytes;
    return evicted;
  }

  CachedTilePtr Load(const std::string& digest, const Loader& loader) {
    CachedTilePtr tile = loader();
    if (tile == nullptr) {
      throw Error(ErrorCode::kInternal, "tile cache: the loader returned nothing");
    }
    const size_t bytes = tile->MemoryBytes();
    std::vector<CachedTilePtr> evicted;
    const std::lock_guard lock(mutex);
    loading.erase(digest);
    evicted = Insert(digest, tile, bytes);
    return tile;
  }
};

TileCache::TileCache(size_t max_bytes) : impl_(std::make_unique<Impl>()) {
  if (max_bytes == 0) {
    throw Error(ErrorCode::kInvalidArgument, "the size of the tile cache must be above 0 bytes");
  }
  impl_->stats.max_bytes = max_bytes;
}

TileCache::~TileCache() = default;

CachedTilePtr TileCache::GetOrLoad(const std::string& digest, const Loader& loader) {
  std::promise<CachedTilePtr> promise;
  {
    std::unique_lock lock(impl_->mutex);
    if (const auto found = impl_->entries.find(digest); found != impl_->entries.end()) {
      ++impl_->stats.num_hits;
      impl_->recently_used.splice(impl_->recently_used.begin(), impl_->recently_used,
                                  found->second.position);
      return found->second.tile;
    }
    if (const auto found = impl_->loading.find(digest); found != impl_->loading.end()) {
      ++impl_->stats.num_hits;
      const std::shared_future<CachedTilePtr> future = found->second;
      lock.unlock();
      return future.get();
    }
    ++impl_->stats.num_misses;
    impl_->loading.emplace(digest, promise.get_future().share());
  }
  try {
    CachedTilePtr tile = impl_->Load(digest, loader);
    promise.set_value(tile);
    return tile;
  } catch (...) {
    {
      const std::lock_guard lock(impl_->mutex);
      impl_->loading.erase(digest);
    }
    promise.set_exception(std::current_exception());
    throw;
  }
}

CachedTilePtr TileCache::Peek(const std::string& digest) const {
  const std::lock_guard lock(impl_->mutex);
  const auto found = impl_->entries.find(digest);
  return found == impl_->entries.end() ? nullptr : found->second.tile;
}

TileCacheStats TileCache::Stats() const {
  const std::lock_guard lock(impl_->mutex);
  TileCacheStats stats = impl_->stats;
  stats.num_entries = impl_->entries.size();
  return stats;
}

void TileCache::Clear() {
  std::unordered_map<std::string, Impl::Entry> cleared;  // Destroyed after the lock is released.
  const std::lock_guard lock(impl_->mutex);
  cleared.swap(impl_->entries);
  impl_->recently_used.clear();
  impl_->stats.bytes = 0;
}

}  // namespace cairn
