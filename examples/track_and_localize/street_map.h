// Makes a map of a rendered street with the project's own ingest.
#ifndef CAIRN_EXAMPLES_TRACK_AND_LOCALIZE_STREET_MAP_H_
#define CAIRN_EXAMPLES_TRACK_AND_LOCALIZE_STREET_MAP_H_

#include <string>

#include "cli/demo/street/street_scene.h"

namespace cairn {

// Photographs the street as a mapping vehicle does, reconstructs it and writes the map to
// `map_path`. Replaces an existing map.
void MakeStreetMap(const StreetScene& scene, const std::string& map_path);

}  // namespace cairn

#endif  // CAIRN_EXAMPLES_TRACK_AND_LOCALIZE_STREET_MAP_H_
