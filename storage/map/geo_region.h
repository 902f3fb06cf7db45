// A region on the ground: a box or polygons.
#ifndef CAIRN_STORAGE_MAP_GEO_REGION_H_
#define CAIRN_STORAGE_MAP_GEO_REGION_H_

#include <vector>

#include "core/geodesy.h"
#include "core/tile_id.h"

namespace cairn {

// A corner of a polygon, degrees.
struct LonLat {
  double lon_deg = 0.0;
  double lat_deg = 0.0;
};

// Closed rings: the first is the outline, the others are holes. The first corner need not be
// repeated at the end. Edges are straight in longitude and latitude, as in GeoJSON.
using GeoPolygon = std::vector<std::vector<LonLat>>;

class GeoRegion {
 public:
  // Throws Error(kBadInput) unless south <= north and all angles are in range. The box crosses the
  // antimeridian if west > east.
  static GeoRegion OfBox(double south_deg, double west_deg, double north_deg, double east_deg);
  // Throws Error(kBadInput) if there is no polygon, a ring has fewer than three corners, or a
  // corner is not on Earth.
  static GeoRegion OfPolygons(std::vector<GeoPolygon> polygons);

  // Boxes that together hold the region.
  const std::vector<GeoBox>& boxes() const { return boxes_; }

  // Returns true if the region and the tile's square have a point in common.
  bool Meets(TileId tile_id) const;

 private:
  std::vector<GeoPolygon> polygons_;
  std::vector<GeoBox> boxes_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_GEO_REGION_H_
