// A thread-safe cache, bounded in bytes, that loads each missing value once.
#ifndef CAIRN_STORAGE_MAP_TILE_CACHE_H_
#define CAIRN_STORAGE_MAP_TILE_CACHE_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace cairn {

struct TileCacheStats {
  uint64_t num_hits = 0;
  uint64_t num_misses = 0;  // Each miss is one load; callers that wait for the load count as hits.
  uint64_t num_evictions = 0;
  size_t num_entries = 0;
  size_t bytes = 0;
  size_t max_bytes = 0;
};

// The base class of cached values: a tile in the form that its user searches. The engine derives
// from it.
class CachedTile {
 public:
  virtual ~CachedTile() = default;
  virtual size_t MemoryBytes() const = 0;
};

// Evicts the least recently used values once the sum of their bytes exceeds the bound. Nothing is
// ever invalidated, because keys are digests of the tiles' payloads; tiles of old map versions age
// out. An evicted value stays alive as long as a caller holds it. Safe to call from any thread;
// loads of different tiles run in parallel.
class TileCache {
 public:
  using Loader = std::function<std::shared_ptr<const CachedTile>()>;

  // A value larger than the bound is returned but not kept. Throws Error(kInvalidArgument) if
  // `max_bytes` is 0.
  explicit TileCache(size_t max_bytes);
  ~TileCache();
  TileCache(const TileCache&) = delete;
  TileCache& operator=(const TileCache&) = delete;

  // Returns the cached value, or runs `loader` in the calling thread. Threads that request a tile
  // while another thread loads it wait for that load. If the loader throws, every waiting thread
  // gets the exception and nothing is cached: the next call loads again.
  std::shared_ptr<const CachedTile> GetOrLoad(const std::string& digest, const Loader& loader);

  // Returns the value if it is loaded, else null. Does not wait and does not count as a hit or a
  // miss.
  std::shared_ptr<const CachedTile> Peek(const std::string& digest) const;

  TileCacheStats Stats() const;
  void Clear();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_TILE_CACHE_H_
