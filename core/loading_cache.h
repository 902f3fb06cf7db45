// A thread-safe cache, bounded in bytes, that loads each missing value once.
#ifndef CAIRN_CORE_LOADING_CACHE_H_
#define CAIRN_CORE_LOADING_CACHE_H_

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/error.h"

namespace cairn {

struct CacheStats {
  uint64_t num_hits = 0;
  uint64_t num_misses = 0;  // Each miss is one load; callers that wait for the load count as hits.
  uint64_t num_evictions = 0;
  size_t num_entries = 0;
  size_t bytes = 0;
  size_t max_bytes = 0;
};

// `Value` has MemoryBytes(). Keys are digests of what values are made from, so nothing is ever
// invalidated. Evicts the least recently used values once the sum of their bytes exceeds the bound.
// An evicted value stays alive as long as a caller holds it. Safe to call from any thread; loads of
// different values run in parallel.
template <typename Value>
class LoadingCache {
 public:
  using Pointer = std::shared_ptr<const Value>;
  using Loader = std::function<Pointer()>;

  // A value larger than the bound is returned but not kept. Throws Error(kInvalidArgument) if
  // `max_bytes` is 0.
  explicit LoadingCache(size_t max_bytes) {
    if (max_bytes == 0) {
      throw Error(ErrorCode::kInvalidArgument, "the size of the tile cache must be above 0 bytes");
    }
    stats_.max_bytes = max_bytes;
  }
  LoadingCache(const LoadingCache&) = delete;
  LoadingCache& operator=(const LoadingCache&) = delete;

  // Returns the cached value, or runs `loader` in the calling thread. Threads that request a value
  // while another thread loads it wait for that load. If the loader throws, every waiting thread
  // gets the exception and nothing is cached: the next call loads again.
  Pointer GetOrLoad(const std::string& key, const Loader& loader) {
    std::promise<Pointer> promise;
    {
      std::unique_lock lock(mutex_);
      if (const auto found = entries_.find(key); found != entries_.end()) {
        ++stats_.num_hits;
        recently_used_.splice(recently_used_.begin(), recently_used_, found->second.position);
        return found->second.value;
      }
      if (const auto found = loading_.find(key); found != loading_.end()) {
        ++stats_.num_hits;
        const std::shared_future<Pointer> future = found->second;
        lock.unlock();
        return future.get();
      }
      ++stats_.num_misses;
      loading_.emplace(key, promise.get_future().share());
    }
    try {
      Pointer value = Load(key, loader);
      promise.set_value(value);
      return value;
    } catch (...) {
      {
        const std::lock_guard lock(mutex_);
        loading_.erase(key);
      }
      promise.set_exception(std::current_exception());
      throw;
    }
  }

  // Returns the value if it is loaded, else null. Does not wait and does not count as a hit or a
  // miss.
  Pointer Peek(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(key);
    return found == entries_.end() ? nullptr : found->second.value;
  }

  CacheStats Stats() const {
    const std::lock_guard lock(mutex_);
    CacheStats stats = stats_;
    stats.num_entries = entries_.size();
    return stats;
  }

  void Clear() {
    std::unordered_map<std::string, Entry> cleared;  // Destroyed after the lock is released.
    const std::lock_guard lock(mutex_);
    cleared.swap(entries_);
    recently_used_.clear();
    stats_.bytes = 0;
  }

 private:
  struct Entry {
    Pointer value;
    size_t bytes = 0;
    std::list<std::string>::iterator position;  // In recently_used_.
  };

  Pointer Load(const std::string& key, const Loader& loader) {
    Pointer value = loader();
    if (value == nullptr) {
      throw Error(ErrorCode::kInternal, "tile cache: the loader returned nothing");
    }
    const size_t bytes = value->MemoryBytes();
    std::vector<Pointer> evicted;
    const std::lock_guard lock(mutex_);
    loading_.erase(key);
    evicted = Insert(key, value, bytes);
    return value;
  }

  // Keeps the value if it fits. Returns the evicted values, so that the caller destroys them
  // without holding the lock.
  std::vector<Pointer> Insert(const std::string& key, const Pointer& value, size_t bytes) {
    std::vector<Pointer> evicted;
    if (bytes > stats_.max_bytes) {
      return evicted;
    }
    while (stats_.bytes + bytes > stats_.max_bytes) {
      const auto oldest = entries_.find(recently_used_.back());
      stats_.bytes -= oldest->second.bytes;
      evicted.push_back(std::move(oldest->second.value));
      entries_.erase(oldest);
      recently_used_.pop_back();
      ++stats_.num_evictions;
    }
    recently_used_.push_front(key);
    entries_[key] = {value, bytes, recently_used_.begin()};
    stats_.bytes += bytes;
    return evicted;
  }

  mutable std::mutex mutex_;              // Guards all members.
  std::list<std::string> recently_used_;  // The front is the most recently used.
  std::unordered_map<std::string, Entry> entries_;
  std::unordered_map<std::string, std::shared_future<Pointer>> loading_;
  CacheStats stats_;
};

}  // namespace cairn

#endif  // CAIRN_CORE_LOADING_CACHE_H_
