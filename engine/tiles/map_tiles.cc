#include "engine/tiles/map_tiles.h"

#include <utility>

#include "storage/tile/tile_codec.h"

namespace cairn {

std::optional<TileRecord> FindTile(const MapTiles& map, TileId tile_id) {
  for (TileRecord& record : map.FindTiles(tile_id.Bounds())) {
    if (record.tile_id == tile_id) {
      return std::move(record);
    }
  }
  return std::nullopt;
}

std::optional<SessionAccuracy> AccuracyOf(const std::set<SessionId>& sessions,
                                          const MapSnapshot& map) {
  const std::vector<SessionAccuracy> accuracies =
      map.AccuraciesOf({sessions.begin(), sessions.end()});
  return accuracies.empty() ? std::nullopt : std::optional(RootMeanSquare(accuracies));
}

StoredTile SnapshotTiles::LoadTile(const TileRecord& record) const {
  StoredTile tile;
  tile.payload = snapshot_.LoadPayload(record.payload_id);
  tile.accuracy = AccuracyOf(SessionsInPayload(tile.payload), snapshot_);
  return tile;
}

}  // namespace cairn
