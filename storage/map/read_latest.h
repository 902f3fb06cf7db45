// Reads the latest version of a map, also while versions are pruned.
#ifndef CAIRN_STORAGE_MAP_READ_LATEST_H_
#define CAIRN_STORAGE_MAP_READ_LATEST_H_

#include "core/error.h"
#include "storage/map/map_store.h"

namespace cairn {

// Calls `read` with `snapshot` and returns its result. If its version is pruned meanwhile, calls
// `read` once more, with the version that is the latest then. Throws what `read` throws;
// Error(kUnavailable) if the second version is pruned, too, or if the map's server does not answer
// by the deadline.
template <typename Read>
auto ReadLatest(const MapStore& store, const MapSnapshot& snapshot, ReadDeadline deadline,
                const Read& read) {
  try {
    return read(snapshot);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kUnavailable) {
      throw;
    }
    const MapSnapshot latest = store.Snapshot(deadline);
    if (latest.version() == snapshot.version()) {
      throw;
    }
    return read(latest);
  }
}

// As above, with a snapshot of the latest version.
template <typename Read>
auto ReadLatest(const MapStore& store, ReadDeadline deadline, const Read& read) {
  return ReadLatest(store, store.Snapshot(deadline), deadline, read);
}

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_READ_LATEST_H_
