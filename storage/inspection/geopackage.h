// GeoPackage geometry blobs (OGC 12-128r17, clause 2.1.3). Private to storage; does not use SQLite.
#ifndef CAIRN_STORAGE_INSPECTION_GEOPACKAGE_H_
#define CAIRN_STORAGE_INSPECTION_GEOPACKAGE_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geodesy.h"
#include "core/tile_id.h"

namespace cairn {

// A box in the axes of a geometry, degrees: x is the longitude and y the latitude.
struct GeometryEnvelope {
  double min_x = 0.0, max_x = 0.0, min_y = 0.0, max_y = 0.0;
  bool is_empty = true;
};

// Returns a POINT Z; z is the height.
std::vector<uint8_t> PointGeometry(const Geodetic& position);

// Returns the POLYGON of a tile's square, counter-clockwise, with the envelope in the header. At
// the antimeridian, longitudes continue past 180 degrees. The polygon of a tile that contains a
// pole is its bounding box over all longitudes, because the corners say little about longitudes
// there.
std::vector<uint8_t> TileGeometry(TileId tile_id);

// Returns the envelope of any geometry blob, from the header or else from the coordinates; nothing
// if the bytes are not a GeoPackage geometry.
std::optional<GeometryEnvelope> EnvelopeOfGeometry(std::span<const uint8_t> blob);

}  // namespace cairn

#endif  // CAIRN_STORAGE_INSPECTION_GEOPACKAGE_H_
