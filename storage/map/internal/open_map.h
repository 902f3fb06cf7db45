// An open map with its caches and counters. Private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_OPEN_MAP_H_
#define CAIRN_STORAGE_MAP_INTERNAL_OPEN_MAP_H_

#include <atomic>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>
#include <vector>

#include "storage/map/internal/map_backend.h"
#include "storage/map/internal/version_cache.h"

namespace cairn {

// The map store and its snapshots share one object. Safe to call from any thread.
class OpenMap {
 public:
  explicit OpenMap(std::unique_ptr<MapBackend> backend) : backend_(std::move(backend)) {}

  MapBackend& backend() { return *backend_; }
  MapHead Head(ReadDeadline deadline);
  MapStoreStats Stats() const;

  // Calls read(connection) with a borrowed connection and counts the call.
  template <typename Read>
  auto Call(ReadDeadline deadline, const Read& read) {
    const Counting counting(this);
    const Borrowed borrowed(backend_.get(), deadline);
    return read(borrowed.connection());
  }

  // Returns the cache of the head's version. Keeps the caches of the newest two versions that were
  // asked for, so that queries that began before an update still find their cache. Drops all caches
  // when PostgreSQL has lost versions.
  std::shared_ptr<VersionCache> CacheOf(const MapHead& head);

  // Keeps decoded codebooks, because they never change unless PostgreSQL loses versions.
  std::shared_ptr<const Codebook> LoadCodebook(CodebookId codebook_id, ReadDeadline deadline);

 private:
  // Counts a call, and its failure if the scope ends with an exception.
  class Counting {
   public:
    explicit Counting(OpenMap* map);
    ~Counting();

   private:
    OpenMap* map_;
    int num_exceptions_;
  };

  // Returns the connection at the end of the scope.
  class Borrowed {
   public:
    Borrowed(MapBackend* backend, ReadDeadline deadline)
        : backend_(backend), connection_(backend->Take(deadline)) {}
    ~Borrowed();
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;
    db::Connection* connection() const { return connection_.get(); }

   private:
    MapBackend* backend_;
    std::unique_ptr<db::Connection> connection_;
  };

  std::unique_ptr<MapBackend> backend_;
  std::atomic<int64_t> num_calls_{0};
  std::atomic<int64_t> num_failed_calls_{0};
  std::mutex mutex_;  // Guards the members below.
  int num_losses_ = 0;
  std::vector<std::shared_ptr<VersionCache>> versions_;
  std::unordered_map<CodebookId, std::shared_ptr<const Codebook>> codebooks_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_OPEN_MAP_H_
