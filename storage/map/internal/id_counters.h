// The counters from which a map numbers its content; private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_ID_COUNTERS_H_
#define CAIRN_STORAGE_MAP_INTERNAL_ID_COUNTERS_H_

#include <cstdint>

#include "storage/database/connection.h"

namespace cairn {

enum class IdCounter { kSession, kKeyframe, kCodebook };

// Returns the id that the next row without an id would get.
int64_t NextId(db::Connection* connection, IdCounter counter);

// Takes `count` ids, which no row gets unless it names them. Returns the first. Works in the open
// write transaction of the connection; a server's counters do not go back if it is rolled back.
int64_t TakeIds(db::Connection* connection, IdCounter counter, int64_t count);

// The same for landmarks, whose counter is a column of cairn_map.
uint64_t TakeLandmarkIds(db::Connection* connection, uint64_t count);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_ID_COUNTERS_H_
