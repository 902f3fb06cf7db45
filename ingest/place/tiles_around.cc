#include "ingest/place/tiles_around.h"

#include <algorithm>
#include <utility>

namespace cairn {

TilesAround::TilesAround(const MapTiles& map, const Geodetic& middle, double radius_m) : map_(map) {
  constexpr size_t kMaxTiles = 400;
  const std::shared_ptr<const Codebook> codebook = map.CurrentCodebook();
  std::vector<std::pair<double, TileId>> by_distance;
  for (const TileRecord& tile : map.FindTiles(BoxAround(middle, radius_m))) {
    if (codebook != nullptr && tile.codebook_id == codebook->id) {
      by_distance.emplace_back(GroundDistanceM(middle, tile.tile_id.Anchor()), tile.tile_id);
    }
  }
  std::ranges::sort(by_distance);
  by_distance.resize(std::min(by_distance.size(), kMaxTiles));
  for (const auto& [distance_m, tile_id] : by_distance) {
    tiles_.insert(tile_id);
  }
}

std::vector<TileRecord> TilesAround::FindTiles(const GeoBox& box) const {
  std::vector<TileRecord> found = map_.FindTiles(box);
  std::erase_if(found, [&](const TileRecord& tile) { return !tiles_.contains(tile.tile_id); });
  return found;
}

}  // namespace cairn
