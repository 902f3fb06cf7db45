#include "storage/geo_box.h"

#include <algorithm>
#include <numbers>

namespace cairn {
namespace {

constexpr double kTurnRad = 2.0 * std::numbers::pi;

bool ContainsLongitude(const GeoBox& box, double lon_rad) {
  return box.CrossesAntimeridian() ? lon_rad >= box.west_rad || lon_rad <= box.east_rad
                                   : lon_rad >= box.west_rad && lon_rad <= box.east_rad;
}

}  // namespace

bool BoxesMeet(const GeoBox& a, const GeoBox& b) {
  return a.south_rad <= b.north_rad && b.south_rad <= a.north_rad &&
         (ContainsLongitude(a, b.west_rad) || ContainsLongitude(b, a.west_rad));
}

std::optional<GeoBox> BoxAroundAll(std::vector<GeoBox> boxes) {
  if (boxes.empty()) {
    return std::nullopt;
  }
  std::sort(boxes.begin(), boxes.end(),
            [](const GeoBox& a, const GeoBox& b) { return a.west_rad < b.west_rad; });
  // Going east from the first box, the widest gap that no box covers is what the union leaves out.
  GeoBox all = boxes.front();
  double reach_rad = boxes.front().west_rad;
  double widest_gap_rad = -1.0;
  const auto take_gap = [&](double next_west_rad) {
    if (next_west_rad - reach_rad > widest_gap_rad) {
      widest_gap_rad = next_west_rad - reach_rad;
      all.east_rad = reach_rad;
      all.west_rad = next_west_rad;
    }
  };
  for (const GeoBox& box : boxes) {
    take_gap(box.west_rad);
    const double east_rad = box.CrossesAntimeridian() ? box.east_rad + kTurnRad : box.east_rad;
    reach_rad = std::max(reach_rad, east_rad);
    all.south_rad = std::min(all.south_rad, box.south_rad);
    all.north_rad = std::max(all.north_rad, box.north_rad);
  }
  take_gap(boxes.front().west_rad + kTurnRad);
  if (widest_gap_rad <= 0.0) {
    return GeoBox{all.south_rad, -std::numbers::pi, all.north_rad, std::numbers::pi};
  }
  const auto wrap = [](double lon_rad) {
    return lon_rad > std::numbers::pi ? lon_rad - kTurnRad : lon_rad;
  };
  all.west_rad = wrap(all.west_rad);
  all.east_rad = wrap(all.east_rad);
  return all;
}

}  // namespace cairn
