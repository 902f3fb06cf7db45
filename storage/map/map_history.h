// Operations on a map's versions: roll back to a version, prune old versions, compact the file.
#ifndef CAIRN_STORAGE_MAP_MAP_HISTORY_H_
#define CAIRN_STORAGE_MAP_MAP_HISTORY_H_

#include <cstdint>
#include <optional>
#include <string>

#include "storage/map/map_store.h"

namespace cairn {

// Publishes a version with the content of an earlier version. Throws Error(kNotFound), which names
// the versions of the map, if `version` is not among them, and Error(kConflict) if `version` is the
// latest or another update runs.
MapVersion RollBack(MapVersion version, MapStore* store);

// Set exactly one of the two.
struct PruneOptions {
  // The number of versions to keep, counting the version that records the pruning.
  std::optional<int64_t> keep = {};
  // Deletes versions that were published before this time: UTC, "2026-01-31T00:00:00Z".
  std::optional<std::string> older_than = {};

  void Validate() const;  // Throws Error(kInvalidArgument).
};

struct PruneReport {
  int64_t num_versions_gone = 0;
  int64_t num_payload_bytes_gone = 0;  // The file keeps the space for later payloads.
  MapVersion version{};                // The latest version of the map.
};

// Deletes old versions and publishes a version that records the pruning. Does nothing if no version
// is old enough. Keeps the content of the latest version. Throws Error(kConflict) if another update
// runs.
PruneReport Prune(const PruneOptions& options, MapStore* store);

// Rewrites the file without free pages. If the process dies, the map is unchanged. Needs space
// for a copy of the map beside the map and for another copy in the directory for temporary files.
// Throws Error(kConflict) if an update runs, Error(kInvalidArgument) if the map is not a file.
void CompactMap(MapStore* store);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_MAP_HISTORY_H_
