#include "storage/map/internal/running_totals.h"

#include <cmath>

#include "core/angles.h"
#include "core/error.h"
#include "storage/inspection/geo_box.h"

namespace cairn {
namespace {

constexpr double kRoundingRad = 1e-12;  // Storing bounds in degrees rounds them.

// If the bounds span less than half a turn, the gap outside of them is wider than any gap between
// tiles. The new bounds then follow from the old bounds and the added tile alone.
bool SpansMoreThanHalf(const GeoBox& box) {
  const double span_rad =
      box.east_rad - box.west_rad + (box.CrossesAntimeridian() ? 2.0 * kPi : 0.0);
  return span_rad > kPi;
}

// The file may hold any numbers.
void Add(int64_t sign, int64_t count, int64_t* total) {
  int64_t signed_count = 0;
  if (__builtin_mul_overflow(sign, count, &signed_count) ||
      __builtin_add_overflow(*total, signed_count, total)) {
    throw Error(ErrorCode::kMapDamaged, "the counts of the map's tiles are too large to add");
  }
}

bool IsAtEdge(const GeoBox& tile, const GeoBox& bounds) {
  return tile.south_rad <= bounds.south_rad + kRoundingRad ||
         tile.north_rad >= bounds.north_rad - kRoundingRad ||
         std::abs(tile.west_rad - bounds.west_rad) <= kRoundingRad ||
         std::abs(tile.east_rad - bounds.east_rad) <= kRoundingRad;
}

}  // namespace

void RunningTotals::CountTile(const TileRecord& tile, int64_t sign) {
  Add(sign, 1, &totals_.num_tiles);
  Add(sign, tile.num_landmarks, &totals_.num_landmarks);
  Add(sign, tile.num_descriptors, &totals_.num_descriptors);
  Add(sign, tile.num_bytes, &totals_.payload_bytes);
}

void RunningTotals::AddTile(const TileRecord& tile) {
  CountTile(tile, 1);
  if (gone_from_edge_.erase(tile.tile_id) > 0) {
    return;  // The bounds still include the tile.
  }
  const GeoBox square = tile.tile_id.Bounds();
  totals_.bounds = totals_.bounds ? BoxAroundAll({*totals_.bounds, square}) : square;
  are_bounds_open_ = are_bounds_open_ || SpansMoreThanHalf(*totals_.bounds);
}

void RunningTotals::RemoveTile(const TileRecord& tile) {
  CountTile(tile, -1);
  if (!totals_.bounds || SpansMoreThanHalf(*totals_.bounds) ||
      IsAtEdge(tile.tile_id.Bounds(), *totals_.bounds)) {
    gone_from_edge_.insert(tile.tile_id);
  }
}

void RunningTotals::SetBounds(const std::optional<GeoBox>& bounds) {
  totals_.bounds = bounds;
  gone_from_edge_.clear();
  are_bounds_open_ = false;
}

}  // namespace cairn
