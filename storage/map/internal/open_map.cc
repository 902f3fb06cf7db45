#include "storage/map/internal/open_map.h"

#include <algorithm>
#include <exception>

#include "storage/map/internal/map_queries.h"
#include "storage/map/internal/version_queries.h"

namespace cairn {

OpenMap::Counting::Counting(OpenMap* map) : map_(map), num_exceptions_(std::uncaught_exceptions()) {
  ++map_->num_calls_;
}

OpenMap::Counting::~Counting() {
  if (std::uncaught_exceptions() > num_exceptions_) {
    ++map_->num_failed_calls_;
  }
}

OpenMap::Borrowed::~Borrowed() {
  try {
    backend_->GiveBack(std::move(connection_));
  } catch (const std::exception&) {
    // If there is no memory for the pool's list, the connection is closed instead of kept.
  }
}

MapHead OpenMap::Head(ReadDeadline deadline) {
  if (const std::optional<MapHead> known = backend_->KnownHead()) {
    return *known;
  }
  return {Call(deadline, queries::LatestVersion), false};
}

MapStoreStats OpenMap::Stats() const { return {num_calls_, num_failed_calls_}; }

std::shared_ptr<VersionCache> OpenMap::CacheOf(const MapHead& head) {
  constexpr size_t kMaxVersions = 2;
  const std::lock_guard lock(mutex_);
  if (head.num_losses > num_losses_) {
    num_losses_ = head.num_losses;
    versions_.clear();
    codebooks_.clear();
  }
  for (const std::shared_ptr<VersionCache>& cache : versions_) {
    if (cache->version() == head.version) {
      return cache;
    }
  }
  auto cache = std::make_shared<VersionCache>(head.version);
  versions_.push_back(cache);
  if (versions_.size() > kMaxVersions) {
    versions_.erase(
        std::min_element(versions_.begin(), versions_.end(),
                         [](const auto& a, const auto& b) { return a->version() < b->version(); }));
  }
  return cache;
}

std::shared_ptr<const Codebook> OpenMap::LoadCodebook(CodebookId codebook_id,
                                                      ReadDeadline deadline) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = codebooks_.find(codebook_id); found != codebooks_.end()) {
      return found->second;
    }
  }
  std::shared_ptr<const Codebook> codebook = Call(deadline, [&](db::Connection* connection) {
    return queries::LoadCodebook(connection, codebook_id);
  });
  const std::lock_guard lock(mutex_);
  return codebooks_.emplace(codebook_id, std::move(codebook)).first->second;
}

}  // namespace cairn
