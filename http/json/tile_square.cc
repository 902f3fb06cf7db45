#include "http/json/tile_square.h"

#include <cmath>
#include <vector>

namespace cairn {

nlohmann::ordered_json TileSquareJson(TileId tile_id) {
  using Json = nlohmann::ordered_json;
  Json ring = Json::array();
  std::vector<Geodetic> corners = tile_id.Corners();
  corners.push_back(corners.front());
  const double first_lon_deg = corners.front().lon_deg();
  for (const Geodetic& corner : corners) {
    const double turns = std::round((corner.lon_deg() - first_lon_deg) / 360.0);
    ring.push_back({corner.lon_deg() - 360.0 * turns, corner.lat_deg()});
  }
  return {{"type", "Polygon"}, {"coordinates", Json::array({ring})}};
}

}  // namespace cairn
