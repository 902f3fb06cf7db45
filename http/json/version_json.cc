#include "http/json/version_json.h"

#include <nlohmann/json.hpp>

namespace cairn {

nlohmann::ordered_json VersionJson(const VersionRecord& version) {
  return {{"version", Value(version.version)},
          {"created", version.created_at},
          {"kind", version.kind},
          {"session", version.session},
          {"summary", version.summary},
          {"sessions", version.totals.num_sessions},
          {"keyframes", version.totals.num_keyframes},
          {"tiles", version.totals.num_tiles},
          {"landmarks", version.totals.num_landmarks},
          {"descriptors", version.totals.num_descriptors},
          {"payloadBytes", version.totals.payload_bytes}};
}

}  // namespace cairn
