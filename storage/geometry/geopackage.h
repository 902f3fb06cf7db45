// GeoPackage geometry blobs (OGC 12-128r17, clause 2.1.3); private to storage. No SQLite here.
#ifndef CAIRN_STORAGE_GEOMETRY_GEOPACKAGE_H_
#define CAIRN_STORAGE_GEOMETRY_GEOPACKAGE_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geodesy.h"
#include "core/tile_id.h"

namespace cairn {

// A box in the axes of a geometry: x is the longitude and y the latitude, degrees.
struct GeometryEnvelope {
  double min_x = 0.0, max_x = 0.0, min_y = 0.0, max_y = 0.0;
  bool is_empty = true;
};

// POINT Z with the height as z.
std::vector<uint8_t> PointGeometry(const Geodetic& position);

// POLYGON of a tile's square, counter-clockwise, with its envelope in the header. Longitudes run on
// past 180 degrees on the antimeridian. A tile within a kilometre of a pole, whose corners say
// little about its longitudes, becomes its bounding box over all longitudes if it holds the pole.
std::vector<uint8_t> TileGeometry(TileId tile_id);

// The envelope of any geometry blob, from its header or else from its coordinates; nothing if the
// bytes are not a GeoPackage geometry.
std::optional<GeometryEnvelope> EnvelopeOfGeometry(std::span<const uint8_t> blob);

}  // namespace cairn

#endif  // CAIRN_STORAGE_GEOMETRY_GEOPACKAGE_H_
