#include <exception>
#include <optional>
#include <utility>

#include "storage/map/map_internal.h"
#include "storage/map/map_queries.h"
#include "storage/map/map_store.h"
#include "storage/map/version_queries.h"

namespace cairn {

MapSnapshot::Impl::Impl(std::shared_ptr<ReaderPool> reader_pool)
    : pool(std::move(reader_pool)), connection(pool->Take()) {
  transaction.emplace(connection.get(), sqlite::Transaction::Kind::kDeferred);
  version = queries::CurrentVersion(connection.get());  // The first read starts the snapshot.
}

MapSnapshot::Impl::~Impl() {
  transaction.reset();
  try {
    pool->GiveBack(std::move(connection));
  } catch (const std::exception&) {
    // No memory for the pool's list: the connection is closed instead of kept.
  }
}

MapSnapshot::MapSnapshot(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MapSnapshot::MapSnapshot(MapSnapshot&&) noexcept = default;
MapSnapshot& MapSnapshot::operator=(MapSnapshot&&) noexcept = default;
MapSnapshot::~MapSnapshot() = default;

MapVersion MapSnapshot::version() const { return impl_->version; }

MapInfo MapSnapshot::Info() const { return queries::Info(impl_->connection.get()); }

std::vector<VersionRecord> MapSnapshot::Versions(int64_t limit) const {
  return queries::Versions(impl_->connection.get(), limit);
}

std::vector<TileChange> MapSnapshot::Diff(MapVersion from, MapVersion to) const {
  return queries::Diff(impl_->connection.get(), from, to);
}

std::vector<TileRecord> MapSnapshot::FindTiles(const GeoBox& box) const {
  return queries::FindTiles(impl_->connection.get(), box);
}

std::vector<TileRecord> MapSnapshot::AllTiles(int64_t limit) const {
  return queries::AllTiles(impl_->connection.get(), limit);
}

std::optional<TileRecord> MapSnapshot::FindTile(TileId tile_id) const {
  return queries::FindTile(impl_->connection.get(), tile_id);
}

LargeVector<uint8_t> MapSnapshot::LoadPayload(PayloadId payload_id) const {
  return queries::LoadPayload(impl_->connection.get(), payload_id);
}

std::shared_ptr<const Codebook> MapSnapshot::LoadCodebook(CodebookId codebook_id) const {
  return impl_->pool->LoadCodebook(impl_->connection.get(), codebook_id);
}

std::shared_ptr<const Codebook> MapSnapshot::CurrentCodebook() const {
  const CodebookId codebook_id = queries::CurrentCodebookId(impl_->connection.get());
  return codebook_id == CodebookId{} ? nullptr : LoadCodebook(codebook_id);
}

std::vector<SessionRecord> MapSnapshot::Sessions() const {
  return queries::Sessions(impl_->connection.get());
}

std::optional<SessionRecord> MapSnapshot::FindSession(const std::string& name) const {
  return queries::FindSession(impl_->connection.get(), name);
}

std::vector<KeyframeRecord> MapSnapshot::KeyframesOfSession(SessionId session_id) const {
  return queries::KeyframesOfSession(impl_->connection.get(), session_id);
}

std::vector<KeyframeRecord> MapSnapshot::KeyframesOfTile(TileId tile_id) const {
  return queries::KeyframesOfTile(impl_->connection.get(), tile_id);
}

std::string MapSnapshot::CodebookDigest(CodebookId codebook_id) const {
  return queries::CodebookDigest(impl_->connection.get(), codebook_id);
}

LandmarkId MapSnapshot::NextLandmarkId() const {
  sqlite::Statement row =
      impl_->connection->Prepare("SELECT coalesce(max(next_landmark_id), 1) FROM cairn_map");
  row.Step();
  return LandmarkId(static_cast<uint64_t>(row.Int64(0)));
}

}  // namespace cairn
