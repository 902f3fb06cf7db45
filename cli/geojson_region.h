// Reads a region from a GeoJSON file.
#ifndef CAIRN_CLI_GEOJSON_REGION_H_
#define CAIRN_CLI_GEOJSON_REGION_H_

#include <string>

#include "storage/map/geo_region.h"

namespace cairn {

// Takes all polygons of a Polygon, MultiPolygon, GeometryCollection, Feature or FeatureCollection.
// Throws Error(kBadInput) if the file is not GeoJSON, holds another geometry or is larger than
// 64 MB, and what ReadTextFile throws.
GeoRegion ReadGeoJsonRegion(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_CLI_GEOJSON_REGION_H_
