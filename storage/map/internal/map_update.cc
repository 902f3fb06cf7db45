#include <string>
#include <utility>

#include "core/check.h"
#include "core/error.h"
#include "core/printable.h"
#include "storage/map/internal/id_counters.h"
#include "storage/map/internal/map_internal.h"
#include "storage/map/internal/map_queries.h"
#include "storage/map/map_store.h"
#include "storage/map/utc_time.h"

namespace cairn {
namespace {

bool IsLowerHex(const std::string& text) {
  return text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

void RequireValid(const SessionRecord& session) {
  if (!session.recorded_at.empty() && !IsUtcTime(session.recorded_at)) {
    throw Error(ErrorCode::kInvalidArgument, "session '" + Excerpt(session.name) +
                                                 "': recorded_at '" + Excerpt(session.recorded_at) +
                                                 "' is not a time like 2026-01-31T12:00:00Z");
  }
  if (!IsLowerHex(session.content_digest)) {
    throw Error(ErrorCode::kInvalidArgument, "session '" + Excerpt(session.name) +
                                                 "': content_digest is not lower-case hexadecimal");
  }
  if (session.accuracy && !IsValid(*session.accuracy)) {
    throw Error(ErrorCode::kInvalidArgument,
                "session '" + Excerpt(session.name) + "': the accuracy has impossible numbers");
  }
}

}  // namespace

MapUpdate::Impl::Impl(std::unique_ptr<WriteTransaction> write_transaction)
    : transaction(std::move(write_transaction)), head(transaction->connection()) {}

MapUpdate::MapUpdate(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MapUpdate::MapUpdate(MapUpdate&&) noexcept = default;
MapUpdate::~MapUpdate() = default;

MapVersion MapUpdate::base_version() const { return MapVersion(impl_->head.next_version() - 1); }

std::optional<TileRecord> MapUpdate::FindTile(TileId tile_id) const {
  return queries::FindTile(impl_->connection(), tile_id);
}

LargeVector<uint8_t> MapUpdate::LoadPayload(PayloadId payload_id) const {
  return queries::LoadPayload(impl_->connection(), payload_id);
}

std::optional<SessionRecord> MapUpdate::FindSession(const std::string& name) const {
  return queries::FindSession(impl_->connection(), name);
}

std::vector<SessionRecord> MapUpdate::Sessions() const {
  return queries::Sessions(impl_->connection());
}

std::vector<KeyframeRecord> MapUpdate::KeyframesOfTile(TileId tile_id) const {
  return queries::KeyframesOfTile(impl_->connection(), tile_id);
}

std::vector<TileId> MapUpdate::TilesOfSession(SessionId session_id) const {
  return queries::TilesOfSession(impl_->connection(), session_id);
}

std::shared_ptr<const Codebook> MapUpdate::CurrentCodebook() const {
  const CodebookId codebook_id = queries::CurrentCodebookId(impl_->connection());
  return codebook_id == CodebookId{} ? nullptr
                                     : queries::LoadCodebook(impl_->connection(), codebook_id);
}

CodebookId MapUpdate::AddCodebook(const Codebook& codebook, CodebookId reserved) {
  const CodebookId codebook_id = impl_->head.StoreCodebook(codebook, reserved);
  impl_->head.SetCurrentCodebook(codebook_id);
  return codebook_id;
}

SessionId MapUpdate::AddSession(const SessionRecord& session, SessionId reserved) {
  RequireValid(session);
  if (FindSession(session.name)) {
    throw Error(ErrorCode::kConflict, impl_->connection()->name() +
                                          ": already has a session named '" +
                                          Excerpt(session.name) + "'");
  }
  SessionRecord added = session;
  added.id = reserved;
  added.created_at.clear();
  return impl_->head.InsertSession(added);
}

void MapUpdate::RemoveSession(SessionId session_id) {
  for (const KeyframeId keyframe_id :
       queries::KeyframeIdsOfSession(impl_->connection(), session_id)) {
    impl_->head.RetireKeyframe(keyframe_id);
  }
  impl_->head.RetireSession(session_id);
}

KeyframeId MapUpdate::AddKeyframe(const KeyframeRecord& keyframe, KeyframeId reserved) {
  KeyframeRecord added = keyframe;
  added.id = reserved;
  return impl_->head.InsertKeyframe(added);
}

void MapUpdate::RemoveKeyframe(KeyframeId keyframe_id) { impl_->head.RetireKeyframe(keyframe_id); }

LandmarkId MapUpdate::ReserveLandmarkIds(uint64_t count) {
  return LandmarkId(TakeLandmarkIds(impl_->connection(), count));
}

FirstIds MapUpdate::NextIds() const {
  db::Connection* connection = impl_->connection();
  return {CodebookId(NextId(connection, IdCounter::kCodebook)),
          SessionId(NextId(connection, IdCounter::kSession)),
          KeyframeId(NextId(connection, IdCounter::kKeyframe)),
          queries::NextLandmarkId(connection)};
}

PayloadId MapUpdate::PutTile(const TileRecord& tile, std::span<const uint8_t> payload) {
  return impl_->head.PutTile(tile, payload);
}

void MapUpdate::RemoveTile(TileId tile_id) { impl_->head.RetireTile(tile_id); }

MapVersion MapUpdate::Publish(const VersionNote& note) {
  CAIRN_CHECK(!impl_->is_published, "the update was already published");
  impl_->head.AddVersion(note);
  const auto version = MapVersion(impl_->head.next_version());
  impl_->transaction->Commit();
  impl_->is_published = true;
  return version;
}

}  // namespace cairn
