// Copies a map, for example from a file to a PostgreSQL database.
#ifndef CAIRN_STORAGE_MAP_COPY_MAP_H_
#define CAIRN_STORAGE_MAP_COPY_MAP_H_

#include <cstdint>
#include <functional>
#include <string>

#include "storage/map/map_store.h"

namespace cairn {

// Creates the map `to` with all versions of `from`, their content and their ids. Both are paths or
// URLs, in any combination. Compares each payload with its digest. `progress` may be empty; it
// receives the number of payloads done and the total. Returns the totals of the latest version.
//
// Throws Error(kConflict) if `to` exists, Error(kMapDamaged) if a payload does not match its
// digest, and what MapStore::Open and MapStore::CreateFilled throw. After an error, `to` does not
// exist.
MapInfo CopyMap(const std::string& from, const std::string& to,
                const std::function<void(int64_t, int64_t)>& progress);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_COPY_MAP_H_
