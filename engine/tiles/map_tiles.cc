#include "engine/tiles/map_tiles.h"

#include <utility>

#include "storage/tile/tile_codec.h"

namespace cairn {

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
