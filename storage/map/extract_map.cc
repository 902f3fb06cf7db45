#include "storage/map/extract_map.h"

#include <fmt/format.h>

#include <map>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

std::vector<TileRecord> TilesOf(const MapSnapshot& snapshot, const GeoRegion& region) {
  std::map<TileId, TileRecord> tiles;  // The boxes of two polygons can share tiles.
  for (const GeoBox& box : region.boxes()) {
    for (const TileRecord& tile : snapshot.FindTiles(box)) {
      if (region.Meets(tile.tile_id)) {
        tiles.emplace(tile.tile_id, tile);
      }
    }
  }
  std::vector<TileRecord> in_order;
  for (const auto& [id, tile] : tiles) {
    in_order.push_back(tile);
  }
  return in_order;
}

}  // namespace

MapTotals ExtractMap(const MapStore& from, const GeoRegion& region, const std::string& to) {
  const MapSnapshot snapshot = from.Snapshot();
  const std::vector<TileRecord> tiles = TilesOf(snapshot, region);
  if (tiles.empty()) {
    throw Error(ErrorCode::kNotFound, from.path() + ": has no tile in this region");
  }
  MapTotals totals;
  MapStore::CreateFilled(to, [&](MapStore* store) {
    MapUpdate update = store->BeginUpdate();
    update.CopyTiles(snapshot, tiles);
    update.Publish({.kind = VersionKind::kExtract,
                    .summary = fmt::format("{} of {} tiles of {}, version {}", tiles.size(),
                                           snapshot.Info().num_tiles, from.ShortName(),
                                           Value(snapshot.version()))});
    totals = store->Snapshot().Info();
  });
  return totals;
}

}  // namespace cairn
