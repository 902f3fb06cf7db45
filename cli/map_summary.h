// What `cairn map` prints about the photos.
#ifndef CAIRN_CLI_MAP_SUMMARY_H_
#define CAIRN_CLI_MAP_SUMMARY_H_

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "cli/publish_in_turn.h"

namespace cairn {

// The photos of a session and what became of them.
void PrintMappedPhotos(const MapSessionResult& result);

// A session with its photos and what it became; or why it is not in the map.
nlohmann::ordered_json MapSessionJson(const MapSessionResult& result);
// All that `cairn map --json` prints: the session, or an object with the array `sessions` if there
// are several.
nlohmann::ordered_json MapSessionsJson(const std::vector<MapSessionResult>& results);

}  // namespace cairn

#endif  // CAIRN_CLI_MAP_SUMMARY_H_
