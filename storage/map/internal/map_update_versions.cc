// The parts of MapUpdate that restore and delete versions.
#include <algorithm>
#include <set>
#include <string_view>
#include <vector>

#include "storage/map/internal/accuracy_table.h"
#include "storage/map/internal/map_internal.h"
#include "storage/map/internal/map_queries.h"
#include "storage/map/internal/version_queries.h"

namespace cairn {
namespace {

// Returns the ids that a statement with one parameter selects.
std::vector<int64_t> SelectIds(db::Connection* connection, std::string_view sql, int64_t value) {
  std::vector<int64_t> ids;
  db::Statement rows = connection->Prepare(sql);
  rows.Bind(value);
  while (rows.Step()) {
    ids.push_back(rows.Int64(0));
  }
  return ids;
}

template <typename Record>
std::set<int64_t> IdsOf(const std::vector<Record>& records) {
  std::set<int64_t> ids;
  for (const Record& record : records) {
    ids.insert(Value(record.id));
  }
  return ids;
}

void RestoreTiles(db::Connection* connection, MapVersion version, HeadWriter* head) {
  const std::vector<TileRecord> past = queries::PastTiles(connection, version);
  std::set<int64_t> past_ids;
  for (const TileRecord& tile : past) {
    past_ids.insert(static_cast<int64_t>(tile.tile_id.value()));
  }
  for (const int64_t id :
       SelectIds(connection, "SELECT tile_id FROM cairn_tiles WHERE since > ?", Value(version))) {
    if (!past_ids.contains(id)) {
      head->RetireTile(TileId::FromValue(static_cast<uint64_t>(id)));
    }
  }
  for (const TileRecord& tile : past) {
    head->PutStoredTile(tile);
  }
}

// Sessions and keyframes never change, so rows that both versions have stay untouched.
void RestoreSessions(db::Connection* connection, MapVersion version, HeadWriter* head) {
  const std::vector<KeyframeRecord> past_keyframes = queries::PastKeyframes(connection, version);
  const std::vector<SessionRecord> past_sessions = queries::PastSessions(connection, version);
  const std::vector<int64_t> new_keyframes = SelectIds(
      connection, "SELECT keyframe_id FROM cairn_keyframe_poses WHERE since > ?", Value(version));
  const std::vector<int64_t> new_sessions = SelectIds(
      connection, "SELECT session_id FROM cairn_sessions WHERE since > ?", Value(version));
  const std::set<int64_t> kept_keyframes = IdsOf(past_keyframes);
  const std::set<int64_t> kept_sessions = IdsOf(past_sessions);
  for (const int64_t id : new_keyframes) {
    if (!kept_keyframes.contains(id)) {
      head->RetireKeyframe(KeyframeId(id));
    }
  }
  for (const int64_t id : new_sessions) {
    if (!kept_sessions.contains(id)) {
      head->RetireSession(SessionId(id));
    }
  }
  const std::set<int64_t> there_sessions(new_sessions.begin(), new_sessions.end());
  for (const SessionRecord& session : past_sessions) {
    if (!there_sessions.contains(Value(session.id))) {
      head->InsertSession(session);
    }
  }
  const std::set<int64_t> there_keyframes(new_keyframes.begin(), new_keyframes.end());
  for (const KeyframeRecord& keyframe : past_keyframes) {
    if (!there_keyframes.contains(Value(keyframe.id))) {
      head->InsertKeyframe(keyframe);
    }
  }
}

}  // namespace

void MapUpdate::RestoreVersion(MapVersion version) {
  db::Connection* connection = impl_->connection();
  queries::RequireVersion(connection, version);
  RestoreTiles(connection, version, &impl_->head);
  RestoreSessions(connection, version, &impl_->head);
  impl_->head.SetCurrentCodebook(queries::CodebookOfVersion(connection, version));
}

int64_t MapUpdate::PruneBefore(MapVersion oldest_kept) {
  db::Connection* connection = impl_->connection();
  const int64_t oldest = std::min(Value(oldest_kept), impl_->head.next_version());
  const std::vector<int64_t> payload_ids = SelectIds(
      connection, "DELETE FROM cairn_past_tiles WHERE until <= ? RETURNING payload_id", oldest);
  int64_t num_bytes = 0;
  for (const int64_t payload_id : payload_ids) {
    num_bytes += impl_->head.DropUnusedPayload(PayloadId(payload_id));
  }
  for (const char* sql : {"DELETE FROM cairn_past_keyframes WHERE until <= ?",
                          "DELETE FROM cairn_past_sessions WHERE until <= ?",
                          "DELETE FROM cairn_versions WHERE version < ?"}) {
    connection->Prepare(sql).Bind(oldest).Run();
  }
  connection->Execute(
      "DELETE FROM cairn_cameras WHERE camera_id NOT IN ("
      "SELECT camera_id FROM cairn_keyframe_poses UNION SELECT camera_id FROM "
      "cairn_past_keyframes);"
      "DELETE FROM cairn_codebooks WHERE codebook_id NOT IN ("
      "SELECT codebook_id FROM cairn_map WHERE codebook_id IS NOT NULL "
      "UNION SELECT codebook_id FROM cairn_versions WHERE codebook_id IS NOT NULL "
      "UNION SELECT codebook_id FROM cairn_tiles UNION SELECT codebook_id FROM cairn_past_tiles)");
  accuracy_table::DropUnused(connection);
  return num_bytes;
}

}  // namespace cairn
