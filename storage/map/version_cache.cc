#include "storage/map/version_cache.h"

namespace cairn {

std::optional<CodebookId> VersionCache::codebook_id() const {
  const std::lock_guard lock(mutex_);
  return codebook_id_;
}

void VersionCache::KeepCodebook(CodebookId codebook_id) {
  const std::lock_guard lock(mutex_);
  codebook_id_ = codebook_id;
}

CellTiles VersionCache::Find(TileCell cell) const {
  const std::lock_guard lock(mutex_);
  const auto found = cells_.find(cell);
  return found == cells_.end() ? nullptr : found->second;
}

void VersionCache::Keep(TileCell cell, CellTiles tiles) {
  constexpr size_t kMaxCells = 16'384;  // A full cell takes 15 kB. Most cells are far from full.
  const std::lock_guard lock(mutex_);
  if (cells_.size() >= kMaxCells) {
    cells_.erase(cells_.begin());
  }
  cells_.insert_or_assign(cell, std::move(tiles));
}

}  // namespace cairn
