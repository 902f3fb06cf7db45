#include "storage/map/internal/tile_ids_near.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/angles.h"
#include "core/tile_id.h"

namespace cairn {
namespace {

// The grid is turned by at most 6 degrees within a zone. A square's bounding box is therefore at
// most 166 m wide, and no point of it is more than 16 m from the square. If the bounding box meets
// the box, then
// - every position in the square is within 166 m of the box, to the east and to the north,
// - some position in the square is within 16 m of it. On the grid, the sides of the largest box
//   bend by at most 9 m more.
constexpr double kZoneMarginM = 170.0;
constexpr double kSquareMarginM = 30.0;
constexpr double kMaxLatRad = 1.4;  // 80 degrees; UPS begins at 84 and -80.

struct IndexRange {
  int first = 0, last = 0;
};

// Returns the tiles at the four corners of the box with a margin, or nothing if the margin crosses
// the antimeridian.
std::optional<std::array<TileId, 4>> CornerTiles(const GeoBox& box, double margin_m) {
  constexpr double kEarthRadiusM = 6.35e6;
  const double lat_margin_rad = margin_m / kEarthRadiusM;
  const double lat_rad = std::max(std::abs(box.south_rad), std::abs(box.north_rad));
  const double lon_margin_rad = lat_margin_rad / std::cos(lat_rad + lat_margin_rad);
  const double south = box.south_rad - lat_margin_rad, north = box.north_rad + lat_margin_rad;
  const double west = box.west_rad - lon_margin_rad, east = box.east_rad + lon_margin_rad;
  if (west < -kPi || east > kPi) {
    return std::nullopt;
  }
  return {{TileId::Containing({south, west, 0.0}), TileId::Containing({south, east, 0.0}),
           TileId::Containing({north, east, 0.0}), TileId::Containing({north, west, 0.0})}};
}

// Zones are much larger than the box, so a box with its corners in one zone lies in that zone.
bool AreInOneZone(const std::array<TileId, 4>& tiles) {
  return std::all_of(tiles.begin(), tiles.end(), [&](const TileId& tile) {
    return tile.zone() == tiles[0].zone() && tile.north() == tiles[0].north() && tile.zone() != 0;
  });
}

// Returns the squares along one axis. `index` returns a tile's index on that axis.
template <typename Index>
IndexRange RangeOf(const std::array<TileId, 4>& tiles, const Index& index) {
  const auto [least, most] =
      std::minmax({index(tiles[0]), index(tiles[1]), index(tiles[2]), index(tiles[3])});
  return {least, most};
}

}  // namespace

std::optional<std::vector<int64_t>> TileIdsNear(const GeoBox& box) {
  constexpr double kMaxSideRad = 0.0013;  // 8.3 km.
  if (box.south_rad < -kMaxLatRad || box.north_rad > kMaxLatRad || box.CrossesAntimeridian() ||
      box.north_rad - box.south_rad > kMaxSideRad || box.north_rad < box.south_rad) {
    return std::nullopt;
  }
  const double lat_rad = std::max(std::abs(box.south_rad), std::abs(box.north_rad));
  if ((box.east_rad - box.west_rad) * std::cos(lat_rad) > kMaxSideRad) {
    return std::nullopt;
  }
  const auto around = CornerTiles(box, kZoneMarginM);
  if (!around || !AreInOneZone(*around)) {
    return std::nullopt;
  }
  const std::array<TileId, 4> corners = *CornerTiles(box, kSquareMarginM);
  const IndexRange east = RangeOf(corners, [](const TileId& id) { return id.easting_idx(); });
  const IndexRange north = RangeOf(corners, [](const TileId& id) { return id.northing_idx(); });
  std::vector<int64_t> ids;
  ids.reserve((east.last - east.first + 1) * (north.last - north.first + 1));
  for (int e = east.first; e <= east.last; ++e) {
    for (int n = north.first; n <= north.last; ++n) {
      ids.push_back(static_cast<int64_t>(corners[0].WithIndices(e, n).value()));
    }
  }
  return ids;
}

}  // namespace cairn
