#include "core/position_prior.h"

namespace cairn {

const char* PriorSourceName(PriorSource source) {
  return source == PriorSource::kPhoto ? "exif" : "request";
}

std::optional<PriorSource> PriorSourceFromName(std::string_view name) {
  for (const PriorSource source : {PriorSource::kClient, PriorSource::kPhoto}) {
    if (name == PriorSourceName(source)) {
      return source;
    }
  }
  return std::nullopt;
}

}  // namespace cairn
