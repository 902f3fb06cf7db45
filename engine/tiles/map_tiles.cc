#include "engine/tiles/map_tiles.h"

#include <set>
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

StoredTile SnapshotTiles::LoadTile(const TileRecord& record) const {
  StoredTile tile;
  tile.payload = snapshot_.LoadPayload(record.payload_id);
  const std::set<SessionId> sessions = SessionsInPayload(tile.payload);
  const std::vector<SessionAccuracy> accuracies =
      snapshot_.AccuraciesOf({sessions.begin(), sessions.end()});
  if (!accuracies.empty()) {
    tile.accuracy = RootMeanSquare(accuracies);
  }
  return tile;
}

}  // namespace cairn
