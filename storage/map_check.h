// The thorough check of a map; private to storage.
#ifndef CAIRN_STORAGE_MAP_CHECK_H_
#define CAIRN_STORAGE_MAP_CHECK_H_

#include <cstdint>
#include <functional>

#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

namespace cairn {

// See MapStore::Check. Damage that SQLite finds on the way ends the check and is reported.
CheckReport CheckMap(sqlite::Connection* connection,
                     const std::function<void(int64_t, int64_t)>& progress);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_CHECK_H_
