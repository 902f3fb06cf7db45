// All tiles of a small city as one reconstruction, for tools that want it whole.
#ifndef CAIRN_LAB_CITY_WHOLE_CITY_H_
#define CAIRN_LAB_CITY_WHOLE_CITY_H_

#include <functional>

#include "ingest/sfm/reconstruction.h"
#include "lab/city/cameras/simulated_mapping.h"

namespace cairn {

// The tiles one after the other; their tracks are not joined. The world is `site` but for its
// errors. Throws Error(kInvalidArgument), naming the largest possible area, if it would need more
// than `max_bytes` of memory. `progress` (may be empty) gets tiles done and total.
Reconstruction MapWholeCity(const SimulatedMapping& mapping, int num_threads, double max_bytes,
                            const std::function<void(int done, int total)>& progress);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_WHOLE_CITY_H_
