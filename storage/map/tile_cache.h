// A byte-bounded, thread-safe cache that loads each missing value once.
#ifndef CAIRN_STORAGE_MAP_TILE_CACHE_H_
#define CAIRN_STORAGE_MAP_TILE_CACHE_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "storage/ids.h"

namespace cairn {

struct TileCacheStats {
  uint64_t num_hits = 0;
  uint64_t num_misses = 0;  // Each miss is one load; callers that waited for it count as hits.
  uint64_t num_evictions = 0;
  size_t num_entries = 0;
  size_t bytes = 0;
  size_t max_bytes = 0;
};

// What the cache holds: a tile in whatever form its user searches it. The engine derives from it.
class CachedTile {
 public:
  virtual ~CachedTile() = default;
  virtual size_t MemoryBytes() const = 0;
};

// Least-recently-used by bytes. A payload id names bytes that never change, so nothing is ever
// invalidated: tiles of old map versions just age out. Values stay alive while someone holds them,
// even after eviction. Safe to call from any thread; loads of different tiles run in parallel.
class TileCache {
 public:
  using Loader = std::function<std::shared_ptr<const CachedTile>()>;

  // A value larger than the bound is handed out but not kept. Throws Error(kInvalidArgument) if
  // `max_bytes` is 0.
  explicit TileCache(size_t max_bytes);
  ~TileCache();
  TileCache(const TileCache&) = delete;
  TileCache& operator=(const TileCache&) = delete;

  // Returns the cached value, or runs `loader` in the calling thread. Threads that ask for a tile
  // that another thread is loading wait for that one load. An exception from the loader reaches
  // every waiting thread and is not cached: the next call loads again.
  std::shared_ptr<const CachedTile> GetOrLoad(PayloadId payload_id, const Loader& loader);

  // The value if it is there and loaded, else null; does not wait and does not count.
  std::shared_ptr<const CachedTile> Peek(PayloadId payload_id) const;

  TileCacheStats Stats() const;
  void Clear();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_TILE_CACHE_H_
