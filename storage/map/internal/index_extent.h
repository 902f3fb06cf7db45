// Finds the edges of a spatial index without reading all of it; private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_INDEX_EXTENT_H_
#define CAIRN_STORAGE_MAP_INTERNAL_INDEX_EXTENT_H_

#include <optional>
#include <string>

#include "core/geodesy.h"
#include "storage/database/connection.h"
#include "storage/inspection/geopackage.h"

namespace cairn {

// Spatial indices round boxes outwards to floats, which lie 3e-5 degrees apart at 360.
inline constexpr double kIndexSlackDeg = 1e-4;

// Returns the extent of the R*Tree `index` (id, minx, maxx, miny, maxy) of an SQLite map, as the
// tree has it. The extent lies within `outer`. Reads the rows in strips along the edges of `outer`,
// which grow until they hold something.
GeometryEnvelope IndexExtent(db::Connection* connection, const std::string& index,
                             const GeometryEnvelope& outer);

// Returns the box around the squares of all tiles, which lies within `outer`; to the bit what
// queries::BoundsOfTiles returns. Reads the tiles at the edges, and all tiles if the box is near
// the antimeridian or a pole or spans half of the globe.
std::optional<GeoBox> BoundsWithin(db::Connection* connection, const GeoBox& outer);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_INDEX_EXTENT_H_
