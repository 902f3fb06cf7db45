#include "engine/nearest_tile.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/angles.h"

namespace cairn {
namespace {

// Half of the Earth's circumference: no place is farther away.
constexpr double kFarthestM = 20.1e6;
// Boxes around the position grow in small steps, so that the first one that meets tiles has few of
// them, whatever the size of the map.
constexpr double kFirstStepM = 150.0;
constexpr double kGrowth = 1.3;

// The longitude of the box that is nearest to `lon_rad`.
double NearestLonRad(const GeoBox& box, double lon_rad) {
  const auto east_of_west = [&](double other_rad) {
    const double turn = std::fmod(other_rad - box.west_rad, 2.0 * kPi);
    return turn < 0.0 ? turn + 2.0 * kPi : turn;
  };
  if (east_of_west(lon_rad) <= east_of_west(box.east_rad)) {
    return lon_rad;
  }
  const auto gap = [&](double other_rad) {
    return std::abs(std::remainder(lon_rad - other_rad, 2.0 * kPi));
  };
  return gap(box.west_rad) < gap(box.east_rad) ? box.west_rad : box.east_rad;
}

double DistanceToBoxM(const Geodetic& position, const GeoBox& box) {
  return GroundDistanceM(position, {std::clamp(position.lat_rad, box.south_rad, box.north_rad),
                                    NearestLonRad(box, position.lon_rad), 0.0});
}

}  // namespace

std::optional<double> NearestTileM(const MapSnapshot& map, const Geodetic& position) {
  const std::optional<GeoBox> bounds = map.Info().bounds;
  if (!bounds) {
    return std::nullopt;
  }
  const double to_bounds_m = DistanceToBoxM(position, *bounds);
  for (double beyond_m = kFirstStepM; beyond_m < kFarthestM; beyond_m *= kGrowth) {
    const std::vector<TileRecord> tiles =
        map.FindTiles(BoxAround(position, to_bounds_m + beyond_m));
    double nearest_m = kFarthestM;
    for (const TileRecord& tile : tiles) {
      nearest_m = std::min(nearest_m, DistanceToBoxM(position, tile.tile_id.Bounds()));
    }
    if (!tiles.empty()) {
      return nearest_m;
    }
  }
  return to_bounds_m;
}

}  // namespace cairn
