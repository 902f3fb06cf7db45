#include "storage/map/geo_region.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/angles.h"
#include "core/error.h"

namespace cairn {
namespace {

using Ring = std::vector<LonLat>;

void RequireOnEarth(const LonLat& corner) {
  if (!(std::abs(corner.lon_deg) <= 180.0 && std::abs(corner.lat_deg) <= 90.0)) {
    throw Error(
        ErrorCode::kBadInput,
        "the region has a corner whose longitude is not in [-180, 180] or whose latitude is "
        "not in [-90, 90] degrees");
  }
}

// Twice the signed area of the triangle abc.
double Cross(const LonLat& a, const LonLat& b, const LonLat& c) {
  return (b.lon_deg - a.lon_deg) * (c.lat_deg - a.lat_deg) -
         (b.lat_deg - a.lat_deg) * (c.lon_deg - a.lon_deg);
}

bool SegmentsCross(const LonLat& a, const LonLat& b, const LonLat& c, const LonLat& d) {
  return Cross(a, b, c) * Cross(a, b, d) <= 0.0 && Cross(c, d, a) * Cross(c, d, b) <= 0.0 &&
         std::max(a.lon_deg, b.lon_deg) >= std::min(c.lon_deg, d.lon_deg) &&
         std::max(c.lon_deg, d.lon_deg) >= std::min(a.lon_deg, b.lon_deg) &&
         std::max(a.lat_deg, b.lat_deg) >= std::min(c.lat_deg, d.lat_deg) &&
         std::max(c.lat_deg, d.lat_deg) >= std::min(a.lat_deg, b.lat_deg);
}

// Calls `visit(from, to)` for each edge until it returns true, and returns whether it did.
template <typename Visit>
bool AnyEdge(const Ring& ring, const Visit& visit) {
  for (size_t i = 0; i < ring.size(); ++i) {
    if (visit(ring[i], ring[(i + 1) % ring.size()])) {
      return true;
    }
  }
  return false;
}

// By the even-odd rule over all rings, so holes are outside.
bool Contains(const GeoPolygon& polygon, const LonLat& point) {
  bool is_inside = false;
  for (const Ring& ring : polygon) {
    AnyEdge(ring, [&](const LonLat& a, const LonLat& b) {
      if ((a.lat_deg > point.lat_deg) != (b.lat_deg > point.lat_deg)) {
        const double lon_deg = a.lon_deg + (point.lat_deg - a.lat_deg) / (b.lat_deg - a.lat_deg) *
                                               (b.lon_deg - a.lon_deg);
        is_inside = is_inside != (point.lon_deg < lon_deg);
      }
      return false;
    });
  }
  return is_inside;
}

bool PolygonsMeet(const GeoPolygon& polygon, const Ring& square) {
  if (Contains(polygon, square.front()) || Contains({square}, polygon.front().front())) {
    return true;
  }
  return std::any_of(polygon.begin(), polygon.end(), [&square](const Ring& ring) {
    return AnyEdge(ring, [&square](const LonLat& a, const LonLat& b) {
      return AnyEdge(square,
                     [&](const LonLat& c, const LonLat& d) { return SegmentsCross(a, b, c, d); });
    });
  });
}

// The square, moved east by `turn_deg`. A square on the antimeridian runs on past 180 degrees.
Ring SquareOf(TileId tile_id, double turn_deg) {
  Ring square;
  for (const Geodetic& corner : tile_id.Corners()) {
    const double first_deg = square.empty() ? corner.lon_deg() : square.front().lon_deg;
    square.push_back(
        {first_deg + std::remainder(corner.lon_deg() - first_deg, 360.0), corner.lat_deg()});
  }
  for (LonLat& corner : square) {
    corner.lon_deg += turn_deg;
  }
  return square;
}

GeoBox BoxOf(const Ring& outline) {
  const auto [west, east] =
      std::minmax_element(outline.begin(), outline.end(),
                          [](const LonLat& a, const LonLat& b) { return a.lon_deg < b.lon_deg; });
  const auto [south, north] =
      std::minmax_element(outline.begin(), outline.end(),
                          [](const LonLat& a, const LonLat& b) { return a.lat_deg < b.lat_deg; });
  return {south->lat_deg / kDegPerRad, west->lon_deg / kDegPerRad, north->lat_deg / kDegPerRad,
          east->lon_deg / kDegPerRad};
}

Ring Rectangle(double south_deg, double west_deg, double north_deg, double east_deg) {
  return {
      {west_deg, south_deg}, {east_deg, south_deg}, {east_deg, north_deg}, {west_deg, north_deg}};
}

}  // namespace

GeoRegion GeoRegion::OfBox(double south_deg, double west_deg, double north_deg, double east_deg) {
  if (!(south_deg <= north_deg)) {
    throw Error(ErrorCode::kBadInput,
                "the region has its southern edge north of its northern edge");
  }
  if (west_deg <= east_deg) {
    return OfPolygons({{Rectangle(south_deg, west_deg, north_deg, east_deg)}});
  }
  return OfPolygons({{Rectangle(south_deg, west_deg, north_deg, 180.0)},
                     {Rectangle(south_deg, -180.0, north_deg, east_deg)}});
}

GeoRegion GeoRegion::OfPolygons(std::vector<GeoPolygon> polygons) {
  GeoRegion region;
  if (polygons.empty()) {
    throw Error(ErrorCode::kBadInput, "the region has no polygon");
  }
  for (const GeoPolygon& polygon : polygons) {
    for (const Ring& ring : polygon) {
      if (ring.size() < 3) {
        throw Error(ErrorCode::kBadInput, "the region has a ring of fewer than three corners");
      }
      std::for_each(ring.begin(), ring.end(), RequireOnEarth);
    }
    if (polygon.empty()) {
      throw Error(ErrorCode::kBadInput, "the region has a polygon without an outline");
    }
    region.boxes_.push_back(BoxOf(polygon.front()));
  }
  region.polygons_ = std::move(polygons);
  return region;
}

bool GeoRegion::Meets(TileId tile_id) const {
  for (const double turn_deg : {-360.0, 0.0, 360.0}) {
    const Ring square = SquareOf(tile_id, turn_deg);
    if (std::any_of(polygons_.begin(), polygons_.end(), [&square](const GeoPolygon& polygon) {
          return PolygonsMeet(polygon, square);
        })) {
      return true;
    }
  }
  return false;
}

}  // namespace cairn
