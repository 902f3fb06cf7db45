#include "storage/map/internal/version_cache.h"

namespace cairn {

std::optional<CodebookId> VersionCache::codebook_id() const {
  const std::lock_guard lock(mutex_);
  return codebook_id_;
}

void VersionCache::KeepCodebook(CodebookId codebook_id) {
  const std::lock_guard lock(mutex_);
  codebook_id_ = codebook_id;
}

FoundTiles VersionCache::Find(const std::vector<int64_t>& tile_ids) const {
  FoundTiles found;
  found.tiles.reserve(tile_ids.size());
  const std::lock_guard lock(mutex_);
  for (const int64_t tile_id : tile_ids) {
    const auto cached = tiles_.find(tile_id);
    if (cached == tiles_.end()) {
      found.missing_ids.push_back(tile_id);
    } else if (cached->second != nullptr) {
      found.tiles.push_back(cached->second);
    }
  }
  return found;
}

void VersionCache::Keep(const std::unordered_map<int64_t, FoundTile>& tiles) {
  std::unordered_map<int64_t, FoundTile> dropped;  // Deleted after the lock is released.
  const std::lock_guard lock(mutex_);
  if (tiles_.size() + tiles.size() > kMaxTiles) {
    dropped.swap(tiles_);
  }
  tiles_.insert(tiles.begin(), tiles.end());
}

}  // namespace cairn
