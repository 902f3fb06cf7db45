#include "storage/map/describe_tile.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/angles.h"
#include "core/check.h"
#include "core/geodesy.h"

namespace cairn {
namespace {

// Returns the smallest box around the landmarks. Longitudes are measured from the tile's anchor, so
// a tile at the antimeridian gets a narrow box.
GeoBox LandmarkBounds(const Tile& tile) {
  constexpr double kTurnRad = 2.0 * kPi;
  const Geodetic anchor = tile.id.Anchor();
  const Rigid3d ecef_from_tile = EcefFromEnu(anchor);
  const double infinity = std::numeric_limits<double>::infinity();
  double south_rad = infinity, north_rad = -infinity, west_rad = infinity, east_rad = -infinity;
  for (const Eigen::Vector3f& x_in_tile : tile.x_in_tile) {
    const Geodetic position = GeodeticFromEcef(ecef_from_tile * x_in_tile.cast<double>());
    const double east_of_anchor_rad = std::remainder(position.lon_rad - anchor.lon_rad, kTurnRad);
    south_rad = std::min(south_rad, position.lat_rad);
    north_rad = std::max(north_rad, position.lat_rad);
    west_rad = std::min(west_rad, east_of_anchor_rad);
    east_rad = std::max(east_rad, east_of_anchor_rad);
  }
  return {south_rad, std::remainder(anchor.lon_rad + west_rad, kTurnRad), north_rad,
          std::remainder(anchor.lon_rad + east_rad, kTurnRad)};
}

}  // namespace

TileRecord DescribeTile(const Tile& tile) {
  CAIRN_CHECK(tile.num_landmarks() > 0 && tile.num_keyframes() > 0, "an empty tile is not kept");
  TileRecord record;
  record.tile_id = tile.id;
  record.codebook_id = tile.codebook_id;
  record.num_landmarks = static_cast<int64_t>(tile.num_landmarks());
  record.num_descriptors = static_cast<int64_t>(tile.num_descriptors());
  record.num_keyframes = static_cast<int64_t>(tile.num_keyframes());
  record.min_h_m = std::numeric_limits<double>::infinity();
  record.max_h_m = -std::numeric_limits<double>::infinity();
  const Rigid3d ecef_from_tile = EcefFromEnu(tile.id.Anchor());
  for (const TileKeyframe& keyframe : tile.keyframes) {
    const double h_m =
        GeodeticFromEcef(ecef_from_tile * keyframe.cam_from_tile.Inverse().translation).h_m;
    record.min_h_m = std::min(record.min_h_m, h_m);
    record.max_h_m = std::max(record.max_h_m, h_m);
  }
  record.landmark_bounds = LandmarkBounds(tile);
  return record;
}

}  // namespace cairn
