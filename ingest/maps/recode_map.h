// A map in the codes of another codebook.
#ifndef CAIRN_INGEST_MAPS_RECODE_MAP_H_
#define CAIRN_INGEST_MAPS_RECODE_MAP_H_

#include <cstdint>
#include <functional>

#include "storage/codebook/codebook.h"
#include "storage/map/map_store.h"

namespace cairn {

struct RecodeReport {
  MapVersion map_version{};
  int64_t num_tiles = 0;
  int64_t num_descriptors = 0;
  int64_t num_bytes_before = 0;  // Of the payloads.
  int64_t num_bytes_after = 0;
};

// Publishes a version whose tiles are coded with `codebook`, which new sessions use from then on;
// see Transcoder for what that loses. Landmarks, keyframes, sessions and their ids stay. Earlier
// versions keep their codes, so RollBack undoes it without loss. An empty map just gets the
// codebook. `progress` may be empty; it receives the number of tiles done and the total.
//
// Throws Error(kBadInput) if the descriptors of the map are not those of the codebook, and
// Error(kConflict) if the map is coded with this codebook already, or another update runs.
RecodeReport RecodeMap(const Codebook& codebook, MapStore* store,
                       const std::function<void(int64_t, int64_t)>& progress);

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_RECODE_MAP_H_
