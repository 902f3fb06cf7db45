#include "storage/map/tile_cells.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cairn {
namespace {

constexpr int kCellShift = 2;  // 4 tiles a side.
constexpr int kTilesASide = 1 << kCellShift;
constexpr int kEastingShift = 26;  // As in core/tile_id.h.
constexpr int kIndexBits = 26;
constexpr int kMaxCellsASide = 16;
// If a tile's bounding box meets the box, the tile's center is at most this far outside of the box:
// half of the diagonal of a tile (106 m), plus the bend of the sides of a box of 13 km (21 m).
constexpr double kMarginM = 135.0;
constexpr double kMaxLatRad = 1.4;  // 80 degrees; UPS begins at 84 and -80.

struct IndexRange {
  int first = 0, last = 0;
};

// Returns the four corners of the box with the margin.
std::array<TileId, 4> CornerTiles(const GeoBox& box) {
  constexpr double kEarthRadiusM = 6.35e6;
  const double lat_margin_rad = kMarginM / kEarthRadiusM;
  const double lat_rad = std::max(std::abs(box.south_rad), std::abs(box.north_rad));
  const double lon_margin_rad = lat_margin_rad / std::cos(lat_rad + lat_margin_rad);
  const double south = box.south_rad - lat_margin_rad, north = box.north_rad + lat_margin_rad;
  const double west = box.west_rad - lon_margin_rad, east = box.east_rad + lon_margin_rad;
  return {TileId::Containing({south, west, 0.0}), TileId::Containing({south, east, 0.0}),
          TileId::Containing({north, east, 0.0}), TileId::Containing({north, west, 0.0})};
}

// Zones are much larger than the box, so a box with its corners in one zone lies in that zone.
bool AreInOneZone(const std::array<TileId, 4>& tiles) {
  return std::all_of(tiles.begin(), tiles.end(), [&](const TileId& tile) {
    return tile.zone() == tiles[0].zone() && tile.north() == tiles[0].north() && tile.zone() != 0;
  });
}

// Returns the cells along one axis. `index` returns a tile's index on that axis.
template <typename Index>
IndexRange CellRange(const std::array<TileId, 4>& tiles, const Index& index) {
  const auto [least, most] =
      std::minmax({index(tiles[0]), index(tiles[1]), index(tiles[2]), index(tiles[3])});
  return {least >> kCellShift, most >> kCellShift};
}

}  // namespace

TileCell CellOf(TileId tile_id) {
  constexpr uint64_t kInCell = kTilesASide - 1;
  return TileCell(tile_id.value() & ~(kInCell | kInCell << kEastingShift));
}

std::optional<std::vector<TileCell>> CellsMeeting(const GeoBox& box) {
  constexpr double kMaxSideRad = 0.002;  // 13 km.
  if (box.south_rad < -kMaxLatRad || box.north_rad > kMaxLatRad || box.CrossesAntimeridian() ||
      box.north_rad - box.south_rad > kMaxSideRad || box.north_rad < box.south_rad) {
    return std::nullopt;
  }
  const double lat_rad = std::max(std::abs(box.south_rad), std::abs(box.north_rad));
  if ((box.east_rad - box.west_rad) * std::cos(lat_rad) > kMaxSideRad) {
    return std::nullopt;
  }
  const std::array<TileId, 4> corners = CornerTiles(box);
  if (!AreInOneZone(corners)) {
    return std::nullopt;
  }
  const IndexRange east = CellRange(corners, [](const TileId& id) { return id.easting_idx(); });
  const IndexRange north = CellRange(corners, [](const TileId& id) { return id.northing_idx(); });
  if (east.last - east.first >= kMaxCellsASide || north.last - north.first >= kMaxCellsASide) {
    return std::nullopt;
  }
  const uint64_t zone_bits = corners[0].value() >> (2 * kIndexBits) << (2 * kIndexBits);
  std::vector<TileCell> cells;
  for (int e = east.first; e <= east.last; ++e) {
    for (int n = north.first; n <= north.last; ++n) {
      cells.push_back(TileCell(zone_bits |
                               static_cast<uint64_t>(e) << (kCellShift + kEastingShift) |
                               static_cast<uint64_t>(n) << kCellShift));
    }
  }
  return cells;
}

std::vector<std::pair<int64_t, int64_t>> TileRanges(TileCell cell) {
  std::vector<std::pair<int64_t, int64_t>> ranges;
  for (int64_t column = 0; column < kTilesASide; ++column) {
    const int64_t first = static_cast<int64_t>(cell) + (column << kEastingShift);
    ranges.emplace_back(first, first + kTilesASide - 1);
  }
  return ranges;
}

}  // namespace cairn
