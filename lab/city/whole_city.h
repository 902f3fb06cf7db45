// Maps all tiles of a small city into one reconstruction, for tools that need the city as a whole.
#ifndef CAIRN_LAB_CITY_WHOLE_CITY_H_
#define CAIRN_LAB_CITY_WHOLE_CITY_H_

#include <functional>

#include "core/scene/reconstruction.h"
#include "lab/city/simulated_mapping.h"

namespace cairn {

// Appends the tiles one after the other; their tracks are not joined. The world frame is `site`,
// apart from the mapping errors. `progress` (may be empty) receives the number of finished tiles
// and the total. Throws Error(kInvalidArgument) that names the largest possible area if the result
// would need more than `max_bytes` of memory.
Reconstruction MapWholeCity(const SimulatedMapping& mapping, int num_threads, double max_bytes,
                            const std::function<void(int done, int total)>& progress);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_WHOLE_CITY_H_
