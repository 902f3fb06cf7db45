#include "engine/tiles/fetch_tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>

#include "core/error.h"
#include "core/parallel_for.h"
#include "engine/tiles/search_region.h"

namespace cairn {
namespace {

// Returns the corners of a tile's square in the anchor frame, counter-clockwise from the
// south-west.
std::vector<Eigen::Vector2d> SquareInAnchor(TileId tile_id, const Rigid3d& anchor_from_ecef) {
  std::vector<Eigen::Vector2d> corners;
  for (const Geodetic& corner : tile_id.Corners()) {
    const Eigen::Vector3d x_in_anchor = anchor_from_ecef * EcefFromGeodetic(corner);
    corners.push_back(x_in_anchor.head<2>());
  }
  return corners;
}

// Returns the distance of a point from a convex polygon with counter-clockwise corners; 0 inside.
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

// Returns the tiles whose square intersects the region's disc, nearest first; equally near tiles
// are ordered by tile id.
std::vector<TileRecord> TilesInDisc(const MapTiles& map, const SearchRegion& region) {
  const Rigid3d anchor_from_ecef = region.ecef_from_anchor.Inverse();
  std::vector<std::pair<double, TileRecord>> tiles_by_distance;
  for (TileRecord& tile : map.FindTiles(RegionBounds(region))) {
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

// Queries are projected with the current codebook, so tiles of another codebook cannot be matched.
void RequireCodebook(const std::shared_ptr<const Codebook>& current,
                     const std::vector<TileRecord>& tiles) {
  for (const TileRecord& tile : tiles) {
    if (current == nullptr || tile.codebook_id != current->id) {
      throw Error(ErrorCode::kMapDamaged,
                  fmt::format("tile {} is coded with codebook {}, which is not the map's current "
                              "one; ingest its sessions again",
                              tile.tile_id.ToString(), Value(tile.codebook_id)));
    }
  }
}

// Returns the number of threads for `num_steps` long steps: at most one thread per core.
int NumThreadsFor(size_t num_steps) {
  const auto num_cores = static_cast<size_t>(NumCores());
  return static_cast<int>(std::min(num_steps, num_cores));
}

// Null if the tile was left out.
using TilePointers = std::vector<std::shared_ptr<const SearchableTile>>;

bool IsComplete(const std::shared_ptr<const SearchableTile>& tile) {
  return tile != nullptr && tile->index().is_complete();
}

// Builds the missing parts of the indices, one part of each tile in turn, so that no tile is far
// behind when the time runs out. Concurrent threads work on different tiles.
void CompleteIndices(const TilePointers& tiles, const StopFunction& should_stop) {
  const auto has_more = [](const auto& tile) { return tile != nullptr && !IsComplete(tile); };
  const size_t num_incomplete = std::count_if(tiles.begin(), tiles.end(), has_more);
  ParallelFor(static_cast<int>(num_incomplete), NumThreadsFor(num_incomplete), [&](int first) {
    for (bool had_more = true; had_more;) {
      had_more = false;
      for (size_t i = 0; i < tiles.size(); ++i) {
        const auto& tile = tiles[(first + i) % tiles.size()];
        if (has_more(tile)) {
          if (should_stop && should_stop()) {
            return;
          }
          tile->index().BuildPart();
          had_more = true;
        }
      }
    }
  });
}

// Gets the tiles of a query from the cache and loads missing ones.
class TileLoader {
 public:
  // `codebook` is that of all tiles.
  TileLoader(const MapTiles& map, std::shared_ptr<const Codebook> codebook, TileCache* cache)
      : map_(map), codebook_(std::move(codebook)), cache_(cache) {}

  // Returns the tiles of the records, in order. Loads missing tiles in parallel, one thread each.
  // Throws the first error in order.
  TilePointers Get(const std::vector<TileRecord>& records, const StopFunction& should_stop) {
    TilePointers tiles(records.size());
    ParallelFor(static_cast<int>(records.size()), NumThreadsFor(NumMissing(records)), [&](int i) {
      const auto has_time = [&should_stop] { return !should_stop || !should_stop(); };
      if (i == 0 || IsCached(records[i]) || has_time()) {
        tiles[i] = Get(records[i]);
        if (has_time()) {
          tiles[i]->Prepare();
        }
      }
    });
    CompleteIndices(tiles, should_stop);
    return tiles;
  }

  int64_t num_loaded() const { return num_loaded_; }

 private:
  size_t NumMissing(const std::vector<TileRecord>& records) const {
    return std::count_if(records.begin(), records.end(),
                         [&](const TileRecord& record) { return !IsCached(record); });
  }

  bool IsCached(const TileRecord& record) const { return cache_->Peek(record.digest) != nullptr; }

  std::shared_ptr<const SearchableTile> Get(const TileRecord& record) {
    const auto load = [&] {
      ++num_loaded_;
      return Load(record);
    };
    auto tile = cache_->GetOrLoad(record.digest, load);
    if (tile->id() != record.tile_id) {  // A damaged map may name the digest of another tile.
      ThrowFor(record, Error(ErrorCode::kMapDamaged, "holds tile " + tile->id().ToString()));
    }
    return tile;
  }

  // Fetches a tile, decodes it unless that is done, and builds the first part of its index.
  std::shared_ptr<const SearchableTile> Load(const TileRecord& record) {
    try {
      StoredTile stored = map_.LoadTile(record);
      const IndexOptions& options = cache_->index_options();
      return stored.decoded != nullptr
                 ? MakeSearchableTile(stored.decoded, codebook_, options, stored.accuracy)
                 : MakeSearchableTile(std::move(stored.payload), codebook_, options,
                                      stored.accuracy);
    } catch (const Error& error) {
      ThrowFor(record, error);
    }
  }

  // Throws the error with the name of the tile.
  [[noreturn]] static void ThrowFor(const TileRecord& record, const Error& error) {
    const bool is_absent = error.code() == ErrorCode::kUnavailable;
    throw Error(error.code(),
                fmt::format("tile {}, payload {}: {}{}", record.tile_id.ToString(),
                            Value(record.payload_id), error.what(),
                            is_absent ? "" : "; run `cairn check` to find all damage"));
  }

  const MapTiles& map_;
  const std::shared_ptr<const Codebook> codebook_;
  TileCache* cache_;
  std::atomic<int64_t> num_loaded_ = 0;
};

// Returns the [min, max] heights of the cameras in the frame `anchor`.
std::pair<double, double> HeightBand(const std::vector<TileRecord>& tiles,
                                     const Rigid3d& anchor_from_ecef, double margin_m) {
  double min_z_m = std::numeric_limits<double>::max();
  double max_z_m = std::numeric_limits<double>::lowest();
  for (const TileRecord& tile : tiles) {
    // Computes heights through ECEF, because the ellipsoid falls below the anchor's tangent plane:
    // 2 cm at 500 m.
    Geodetic position = tile.tile_id.Anchor();
    position.h_m = tile.min_h_m;
    min_z_m = std::min(min_z_m, (anchor_from_ecef * EcefFromGeodetic(position)).z());
    position.h_m = tile.max_h_m;
    max_z_m = std::max(max_z_m, (anchor_from_ecef * EcefFromGeodetic(position)).z());
  }
  return {min_z_m - margin_m, max_z_m + margin_m};
}

// Intersects the region's heights with the band. If they are disjoint, the prior's height is wrong
// and the band is used alone.
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

FetchedTiles FetchTiles(const MapTiles& map, const SearchRegion& region,
                        const TilesOptions& options, TileCache* cache,
                        const StopFunction& should_stop) {
  FetchedTiles fetched;
  fetched.region = region;
  std::vector<TileRecord> records = TilesInDisc(map, region);
  fetched.num_found = std::ssize(records);
  fetched.limit_hit = fetched.num_found > options.max_tiles;
  if (fetched.limit_hit) {
    records.resize(static_cast<size_t>(options.max_tiles));
  }
  if (records.empty()) {
    return fetched;
  }
  const std::shared_ptr<const Codebook> codebook = map.CurrentCodebook();
  RequireCodebook(codebook, records);
  const Rigid3d anchor_from_ecef = region.ecef_from_anchor.Inverse();
  TileLoader loader(map, codebook, cache);
  for (std::shared_ptr<const SearchableTile>& tile : loader.Get(records, should_stop)) {
    fetched.is_complete = fetched.is_complete && IsComplete(tile);
    if (tile != nullptr) {
      fetched.num_descriptors += static_cast<int64_t>(tile->num_descriptors());
      const Rigid3d anchor_from_tile = anchor_from_ecef * tile->ecef_from_tile();
      fetched.views.push_back({std::move(tile), anchor_from_tile});
    }
  }
  fetched.num_loaded = loader.num_loaded();
  NarrowHeights(HeightBand(records, anchor_from_ecef, options.height_margin_m), &fetched.region);
  return fetched;
}

}  // namespace cairn
