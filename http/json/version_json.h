// A version of a map as JSON.
#ifndef CAIRN_HTTP_JSON_VERSION_JSON_H_
#define CAIRN_HTTP_JSON_VERSION_JSON_H_

#include <nlohmann/json_fwd.hpp>

#include "storage/map/map_versions.h"

namespace cairn {

// Returns the object of `/v1/versions`. The author is left out, because every client may read it.
nlohmann::ordered_json VersionJson(const VersionRecord& version);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_VERSION_JSON_H_
