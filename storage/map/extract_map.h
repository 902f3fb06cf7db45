// Copies a part of a map into a new map.
#ifndef CAIRN_STORAGE_MAP_EXTRACT_MAP_H_
#define CAIRN_STORAGE_MAP_EXTRACT_MAP_H_

#include <string>

#include "storage/map/geo_region.h"
#include "storage/map/map_store.h"

namespace cairn {

// Creates the map `to` with the tiles of the latest version that the region meets, and with the
// keyframes and sessions of these tiles. Payloads and ids are identical. The new map has its own
// version numbers. Returns the new map's totals. Throws Error(kNotFound) if the region meets no
// tile, Error(kConflict) if `to` exists.
MapTotals ExtractMap(const MapStore& from, const GeoRegion& region, const std::string& to);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_EXTRACT_MAP_H_
