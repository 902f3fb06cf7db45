#include <optional>
#include <unordered_map>
#include <utility>

#include "core/error.h"
#include "storage/inspection/geo_box.h"
#include "storage/map/internal/accuracy_table.h"
#include "storage/map/internal/as_of_queries.h"
#include "storage/map/internal/map_internal.h"
#include "storage/map/internal/map_queries.h"
#include "storage/map/internal/tile_ids_near.h"
#include "storage/map/internal/version_queries.h"
#include "storage/map/map_store.h"
#include "storage/tile/content_digest.h"

namespace cairn {
namespace {

FoundTile WithBounds(TileRecord record) {
  const GeoBox bounds = record.tile_id.Bounds();
  return std::make_shared<BoundedTile>(BoundedTile{std::move(record), bounds});
}

}  // namespace

MapSnapshot::Impl::Impl(std::shared_ptr<OpenMap> open_map, ReadDeadline read_deadline)
    : map(std::move(open_map)),
      deadline(read_deadline),
      head(map->Head(deadline)),
      cache(map->CacheOf(head)) {}

std::vector<FoundTile> MapSnapshot::Impl::Tiles(const std::vector<int64_t>& ids) const {
  FoundTiles found = cache->Find(ids);
  if (found.missing_ids.empty()) {
    return std::move(found.tiles);
  }
  std::unordered_map<int64_t, FoundTile> read;
  for (const int64_t id : found.missing_ids) {
    read[id] = nullptr;
  }
  for (TileRecord& record : Call(as_of::TilesWithIds, found.missing_ids)) {
    const auto id = static_cast<int64_t>(record.tile_id.value());
    found.tiles.push_back(read[id] = WithBounds(std::move(record)));
  }
  cache->Keep(read);
  return std::move(found.tiles);
}

MapSnapshot::MapSnapshot(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MapSnapshot::MapSnapshot(MapSnapshot&&) noexcept = default;
MapSnapshot& MapSnapshot::operator=(MapSnapshot&&) noexcept = default;
MapSnapshot::~MapSnapshot() = default;

MapVersion MapSnapshot::version() const { return impl_->head.version; }

bool MapSnapshot::is_stale() const { return impl_->head.is_stale; }

MapInfo MapSnapshot::Info() const { return impl_->Call(as_of::Info); }

std::vector<VersionRecord> MapSnapshot::Versions(int64_t limit) const {
  return impl_->Call(queries::Versions, limit);
}

std::vector<TileChange> MapSnapshot::Diff(MapVersion from, MapVersion to) const {
  return impl_->map->Call(impl_->deadline, [&](db::Connection* connection) {
    return queries::Diff(connection, from, to);
  });
}

std::vector<TileRecord> MapSnapshot::FindTiles(const GeoBox& box) const {
  const std::optional<std::vector<int64_t>> ids = TileIdsNear(box);
  if (!ids) {
    return impl_->Call(as_of::FindTiles, box);
  }
  std::vector<TileRecord> tiles;
  for (const FoundTile& tile : impl_->Tiles(*ids)) {
    if (BoxesMeet(tile->bounds, box)) {
      tiles.push_back(tile->record);
    }
  }
  queries::SortById(&tiles);
  return tiles;
}

std::vector<TileRecord> MapSnapshot::AllTiles(int64_t limit) const {
  return impl_->Call(as_of::AllTiles, limit);
}

TilePage MapSnapshot::FindTilePage(const TilePageRequest& request) const {
  return impl_->Call(as_of::FindTilePage, request);
}

std::optional<TileRecord> MapSnapshot::FindTile(TileId tile_id) const {
  return impl_->Call(as_of::FindTile, tile_id);
}

LargeVector<uint8_t> MapSnapshot::LoadPayload(PayloadId payload_id) const {
  return impl_->Call(as_of::LoadPayload, payload_id);
}

std::shared_ptr<const Codebook> MapSnapshot::LoadCodebook(CodebookId codebook_id) const {
  try {
    return impl_->map->LoadCodebook(codebook_id, impl_->deadline);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kMapDamaged) {
      impl_->Call(as_of::RequireKept);
    }
    throw;
  }
}

std::shared_ptr<const Codebook> MapSnapshot::CurrentCodebook() const {
  std::optional<CodebookId> codebook_id = impl_->cache->codebook_id();
  if (!codebook_id) {
    codebook_id = impl_->Call(as_of::CurrentCodebookId);
    impl_->cache->KeepCodebook(*codebook_id);
  }
  return *codebook_id == CodebookId{} ? nullptr : LoadCodebook(*codebook_id);
}

std::vector<SessionRecord> MapSnapshot::Sessions() const { return impl_->Call(as_of::Sessions); }

std::optional<SessionRecord> MapSnapshot::FindSession(const std::string& name) const {
  return impl_->Call(as_of::FindSession, name);
}

std::vector<TileId> MapSnapshot::TilesOfSession(SessionId session_id) const {
  return impl_->map->Call(impl_->deadline, [&](db::Connection* connection) {
    return queries::TilesOfSession(connection, session_id);
  });
}

std::vector<SessionAccuracy> MapSnapshot::AccuraciesOf(
    const std::vector<SessionId>& session_ids) const {
  return impl_->map->Call(impl_->deadline, [&](db::Connection* connection) {
    return accuracy_table::Find(connection, session_ids);
  });
}

std::vector<KeyframeRecord> MapSnapshot::KeyframesOfSession(SessionId session_id) const {
  return impl_->Call(as_of::KeyframesOfSession, session_id);
}

std::vector<KeyframeRecord> MapSnapshot::KeyframesOfTile(TileId tile_id) const {
  return impl_->Call(as_of::KeyframesOfTile, tile_id);
}

std::string MapSnapshot::CodebookDigest(CodebookId codebook_id) const {
  return impl_->map->Call(impl_->deadline, [&](db::Connection* connection) {
    return queries::CodebookDigest(connection, codebook_id);
  });
}

CodebookId MapSnapshot::FindCodebook(const Codebook& codebook) const {
  const std::string digest = ContentDigest(EncodeCodebook(codebook));
  return impl_->map->Call(impl_->deadline, [&](db::Connection* connection) {
    return queries::FindCodebook(connection, digest);
  });
}

LandmarkId MapSnapshot::NextLandmarkId() const {
  return impl_->map->Call(impl_->deadline, queries::NextLandmarkId);
}

}  // namespace cairn
