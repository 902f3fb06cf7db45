#include "storage/inspection/geo_box.h"

#include <algorithm>

#include "core/angles.h"

namespace cairn {
namespace {

constexpr double kTurnRad = 2.0 * kPi;

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
  // Walks east from the first box. The union leaves out the widest gap that no box covers.
  GeoBox all = boxes.front();
  double reach_rad = boxes.front().west_rad;
  for (const GeoBox& box : boxes) {  // Boxes beyond a full turn cover the beginning.
    if (box.CrossesAntimeridian()) {
      reach_rad = std::max(reach_rad, box.east_rad);
    }
  }
  double widest_gap_rad = -1.0;
  const auto take_gap = [&](double gap_rad, double next_west_rad) {
    if (gap_rad > widest_gap_rad) {
      widest_gap_rad = gap_rad;
      all.east_rad = reach_rad;
      all.west_rad = next_west_rad;
    }
  };
  for (const GeoBox& box : boxes) {
    take_gap(box.west_rad - reach_rad, box.west_rad);
    const double east_rad = box.CrossesAntimeridian() ? box.east_rad + kTurnRad : box.east_rad;
    reach_rad = std::max(reach_rad, east_rad);
    all.south_rad = std::min(all.south_rad, box.south_rad);
    all.north_rad = std::max(all.north_rad, box.north_rad);
  }
  // The last gap ends where the first box begins, one turn later.
  const double first_west_rad = boxes.front().west_rad;
  take_gap(first_west_rad + kTurnRad - reach_rad, first_west_rad);
  if (widest_gap_rad <= 0.0) {
    return GeoBox{all.south_rad, -kPi, all.north_rad, kPi};
  }
  if (all.east_rad > kPi) {
    all.east_rad -= kTurnRad;
  }
  return all;
}

}  // namespace cairn
