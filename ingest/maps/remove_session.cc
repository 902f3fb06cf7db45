#include "ingest/maps/remove_session.h"

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "core/error.h"
#include "core/printable.h"
#include "ingest/tile_rewriter.h"
#include "ingest/tiles/tile_edit.h"
#include "ingest/tiles/write_tile.h"
#include "storage/codebook/codebook.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

int64_t CountLandmarksOf(const Tile& tile, SessionId session_id) {
  return std::count_if(tile.history.begin(), tile.history.end(), [&](const auto& entry) {
    return entry.session_id == session_id && entry.num_observations > 0;
  });
}

std::optional<Tile> LoadTile(TileId tile_id, const MapUpdate& update) {
  const std::optional<TileRecord> record = update.FindTile(tile_id);
  return record ? std::optional(DecodeTile(update.LoadPayload(record->payload_id))) : std::nullopt;
}

}  // namespace

RemovalReport RemoveSession(const std::string& session_name, MapStore* store) {
  MapUpdate update = store->BeginUpdate();
  const std::optional<SessionRecord> record = update.FindSession(session_name);
  if (!record) {
    throw Error(ErrorCode::kNotFound,
                fmt::format("{}: has no session '{}'", store->path(), Excerpt(session_name)));
  }
  const std::shared_ptr<const Codebook> codebook = update.CurrentCodebook();
  if (codebook == nullptr) {
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("{}: has sessions but no codebook", store->path()));
  }
  RemovalReport report;
  const std::vector<TileId> tiles = update.TilesOfSession(record->id);
  update.RemoveSession(record->id);
  for (const TileId tile_id : tiles) {
    const std::optional<Tile> before = LoadTile(tile_id, update);
    if (!before) {
      continue;
    }
    const Tile after = WithoutSession(*before, record->id);
    WriteTile(after, *codebook, &update);
    const bool is_kept = update.FindTile(tile_id).has_value();
    const size_t num_kept = is_kept ? after.num_landmarks() : 0;
    const auto num_removed = static_cast<int64_t>(before->num_landmarks() - num_kept);
    report.num_landmarks_removed += num_removed;
    report.num_landmarks_shared +=
        is_kept ? CountLandmarksOf(*before, record->id) - num_removed : 0;
    ++(is_kept ? report.num_tiles_rewritten : report.num_tiles_removed);
  }
  report.map_version = update.Publish({.kind = VersionKind::kRemove, .session = session_name});
  return report;
}

}  // namespace cairn
