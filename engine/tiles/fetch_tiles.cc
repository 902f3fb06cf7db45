#include "engine/tiles/fetch_tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>

#include "core/error.h"
#include "engine/prior/search_region.h"
#include "storage/tile_codec.h"

namespace cairn {
namespace {

// The corners of a tile's square in the anchor frame, counter-clockwise from south-west.
std::vector<Eigen::Vector2d> SquareInAnchor(TileId tile_id, const Rigid3d& anchor_from_ecef) {
  std::vector<Eigen::Vector2d> corners;
  for (const Geodetic& corner : tile_id.Corners()) {
    const Eigen::Vector3d x_in_anchor = anchor_from_ecef * EcefFromGeodetic(corner);
    corners.push_back(x_in_anchor.head<2>());
  }
  return corners;
}

// Distance of a point from a convex polygon with counter-clockwise corners; 0 inside.
double DistanceToPolygon(const Eigen::Vector2d& point,
                         const std::vector<Eigen::Vector2d>& corners) {
  bool inside = true;
  double distance = std::numeric_limits<double>::max();
  for (size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d side = corners[(i + 1) % corners.size()] - corners[i];
    const Eigen::Vector2d offset = point - corners[i];
    inside = inside && side.x() * offset.y() - side.y() * offset.x() >= 0.0;
    const double along = std::clamp(offset.dot(side) / side.squaredNorm(), 0.0, 1.0);
    distance = std::min(distance, (offset - along * side).norm());
  }
  return inside ? 0.0 : distance;
}

// Tiles whose square meets the region's disc, nearest first; equally near ones by tile id.
std::vector<TileRecord> TilesInDisc(const MapSnapshot& snapshot, const SearchRegion& region) {
  const Rigid3d anchor_from_ecef = region.ecef_from_anchor.Inverse();
  std::vector<std::pair<double, TileRecord>> tiles_by_distance;
  for (TileRecord& tile : snapshot.FindTiles(RegionBounds(region))) {
    const double distance_m = DistanceToPolygon(region.prior_xy_in_anchor,
                                                SquareInAnchor(tile.tile_id, anchor_from_ecef));
    if (distance_m <= region.radius_m) {
      tiles_by_distance.emplace_back(distance_m, std::move(tile));
    }
  }
  std::stable_sort(tiles_by_distance.begin(), tiles_by_distance.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<TileRecord> tiles;
  for (auto& [distance_m, tile] : tiles_by_distance) {
    tiles.push_back(std::move(tile));
  }
  return tiles;
}

// The tiles to search and, in the counters, how many there were.
std::vector<TileRecord> SelectTiles(const MapSnapshot& snapshot, const SearchRegion& region,
                                    int max_tiles, StageCounters* counters) {
  std::vector<TileRecord> tiles;
  if (region.has_prior) {
    tiles = TilesInDisc(snapshot, region);
    counters->num_tiles_found = static_cast<int64_t>(tiles.size());
  } else {
    tiles = snapshot.AllTiles(max_tiles);
    counters->num_tiles_found = snapshot.Info().num_tiles;
  }
  if (tiles.size() > static_cast<size_t>(max_tiles)) {
    tiles.resize(max_tiles);
  }
  counters->num_tiles_searched = static_cast<int64_t>(tiles.size());
  counters->tile_limit_hit = counters->num_tiles_searched < counters->num_tiles_found;
  return tiles;
}

// Queries are projected with the current codebook; tiles of another cannot be matched with them.
void RequireCurrentCodebook(const MapSnapshot& snapshot, const std::vector<TileRecord>& tiles) {
  const std::shared_ptr<const Codebook> current = snapshot.CurrentCodebook();
  for (const TileRecord& tile : tiles) {
    if (current == nullptr || tile.codebook_id != current->id) {
      throw Error(ErrorCode::kInternal,
                  fmt::format("tile {} is coded with codebook {}, which is not the map's current "
                              "one; ingest its sessions again",
                              tile.tile_id.ToString(), Value(tile.codebook_id)));
    }
  }
}

// The decoded tile of a record; errors name the tile.
Tile DecodePayload(const MapSnapshot& snapshot, const TileRecord& record) {
  try {
    Tile tile = DecodeTile(snapshot.LoadPayload(record.payload_id));
    if (tile.id != record.tile_id) {
      throw Error(ErrorCode::kMapDamaged, fmt::format("holds tile {}", tile.id.ToString()));
    }
    return tile;
  } catch (const Error& error) {
    throw Error(error.code(),
                fmt::format("tile {}, payload {}: {}; `cairn check` looks for more",
                            record.tile_id.ToString(), Value(record.payload_id), error.what()));
  }
}

// Fetches, decodes and indexes one tile.
std::shared_ptr<const SearchableTile> LoadTile(const MapSnapshot& snapshot,
                                               const TileRecord& record,
                                               const IndexOptions& index_options) {
  return std::make_shared<const SearchableTile>(
      DecodePayload(snapshot, record), snapshot.LoadCodebook(record.codebook_id), index_options);
}

// Heights of the cameras in anchor_from_ecef's frame, as [min, max].
std::pair<double, double> HeightBand(const std::vector<TileRecord>& tiles,
                                     const Rigid3d& anchor_from_ecef, double margin_m) {
  double min_z_m = std::numeric_limits<double>::max();
  double max_z_m = std::numeric_limits<double>::lowest();
  for (const TileRecord& tile : tiles) {
    // Through ECEF: the ellipsoid falls off below the anchor's tangent plane, 2 cm in 500 m.
    Geodetic position = tile.tile_id.Anchor();
    position.h_m = tile.min_h_m;
    min_z_m = std::min(min_z_m, (anchor_from_ecef * EcefFromGeodetic(position)).z());
    position.h_m = tile.max_h_m;
    max_z_m = std::max(max_z_m, (anchor_from_ecef * EcefFromGeodetic(position)).z());
  }
  return {min_z_m - margin_m, max_z_m + margin_m};
}

// Narrows the region to the band; takes the band alone if the prior's own height contradicts it.
void NarrowHeights(const std::pair<double, double>& band, SearchRegion* region) {
  const double min_z_m = std::max(band.first, region->min_z_m);
  const double max_z_m = std::min(band.second, region->max_z_m);
  if (min_z_m < max_z_m) {
    region->min_z_m = min_z_m;
    region->max_z_m = max_z_m;
  } else {
    region->min_z_m = band.first;
    region->max_z_m = band.second;
  }
}

}  // namespace

std::vector<TileView> FetchTiles(const MapSnapshot& snapshot, TileCache* cache,
                                 const TilesOptions& options, const IndexOptions& index_options,
                                 SearchRegion* region, StageCounters* counters) {
  const std::vector<TileRecord> records =
      SelectTiles(snapshot, *region, options.max_tiles, counters);
  RequireCurrentCodebook(snapshot, records);
  const Rigid3d anchor_from_ecef = region->ecef_from_anchor.Inverse();
  std::vector<TileView> views;
  for (const TileRecord& record : records) {
    const auto load = [&]() -> std::shared_ptr<const CachedTile> {
      ++counters->num_tiles_loaded;
      return LoadTile(snapshot, record, index_options);
    };
    auto tile =
        std::static_pointer_cast<const SearchableTile>(cache->GetOrLoad(record.payload_id, load));
    counters->num_descriptors += static_cast<int64_t>(tile->tile().num_descriptors());
    const Rigid3d anchor_from_tile = anchor_from_ecef * tile->ecef_from_tile();
    views.push_back({std::move(tile), anchor_from_tile});
  }
  if (!records.empty()) {
    NarrowHeights(HeightBand(records, anchor_from_ecef, options.height_margin_m), region);
  }
  return views;
}

}  // namespace cairn
