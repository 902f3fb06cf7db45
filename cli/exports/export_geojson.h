// Writes what a map covers as GeoJSON (RFC 7946), for GIS programs.
#ifndef CAIRN_CLI_EXPORTS_EXPORT_GEOJSON_H_
#define CAIRN_CLI_EXPORTS_EXPORT_GEOJSON_H_

#include <cstdint>
#include <optional>
#include <string>

#include "storage/map/map_store.h"

namespace cairn {

// A point for each keyframe, at longitude, latitude and ellipsoidal height, with the members image,
// session, keyframe, tile, heading_deg (from north, clockwise) and pitch_deg (upward) of where the
// camera looks. In the order of tiles, only keyframes of `session` if it is given. Returns their
// number. Throws Error(kIo). The memory is that of one tile's keyframes.
int64_t ExportKeyframesGeoJson(const MapSnapshot& map, const std::optional<SessionId>& session,
                               const std::string& path);

// A square for each tile, with the members tile, landmarks, descriptors, keyframes and bytes.
// Returns their number. Throws Error(kIo).
int64_t ExportCoverageGeoJson(const MapSnapshot& map, const std::string& path);

}  // namespace cairn

#endif  // CAIRN_CLI_EXPORTS_EXPORT_GEOJSON_H_
