#include "ingest/place/tiles_around.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace cairn {
namespace {

using DistanceOfTile = std::map<TileId, std::pair<double, TileRecord>>;

// The tiles within the radius of a place, with the distance of their middles, meters.
DistanceOfTile TilesNear(const MapTiles& map, const std::vector<Geodetic>& places,
                         double radius_m) {
  DistanceOfTile found;
  for (const Geodetic& place : places) {
    for (TileRecord& tile : map.FindTiles(BoxAround(place, radius_m))) {
      const double distance_m = GroundDistanceM(place, tile.tile_id.Anchor());
      const auto [known, is_new] = found.try_emplace(tile.tile_id, distance_m, std::move(tile));
      known->second.first = std::min(known->second.first, distance_m);
    }
  }
  return found;
}

}  // namespace

TilesAround::TilesAround(const MapTiles& map, const std::vector<Geodetic>& places, double radius_m)
    : map_(map) {
  constexpr size_t kMaxTiles = 400;
  const std::shared_ptr<const Codebook> codebook = map.CurrentCodebook();
  std::vector<std::pair<double, TileRecord>> by_distance;
  for (auto& [tile_id, tile] : TilesNear(map, places, radius_m)) {
    if (tile.first <= radius_m && codebook != nullptr && tile.second.codebook_id == codebook->id) {
      by_distance.push_back(std::move(tile));
    }
  }
  std::ranges::stable_sort(by_distance, {}, &std::pair<double, TileRecord>::first);
  by_distance.resize(std::min(by_distance.size(), kMaxTiles));
  for (auto& [distance_m, tile] : by_distance) {
    tiles_.push_back(std::move(tile));
  }
  std::ranges::sort(tiles_, {}, &TileRecord::tile_id);
}

std::vector<TileRecord> TilesAround::FindTiles(const GeoBox& box) const {
  std::vector<TileRecord> found;
  for (const TileRecord& tile : tiles_) {
    const GeoBox bounds = tile.tile_id.Bounds();
    if (bounds.south_rad <= box.north_rad && bounds.north_rad >= box.south_rad) {
      found.push_back(tile);
    }
  }
  return found;
}

std::optional<double> DistanceToMapM(const MapTiles& map, const std::vector<Geodetic>& places) {
  constexpr double kFirstM = 500.0, kFarthestM = 2.1e7;
  std::optional<double> nearest_m;
  for (double radius_m = kFirstM; !nearest_m && radius_m < 2.0 * kFarthestM; radius_m *= 2.0) {
    for (const auto& [tile_id, tile] : TilesNear(map, places, radius_m)) {
      nearest_m = std::min(nearest_m.value_or(std::numeric_limits<double>::infinity()), tile.first);
    }
  }
  return nearest_m ? std::optional(std::max(0.0, *nearest_m - 0.5 * TileId::kSideM)) : nearest_m;
}

}  // namespace cairn
