// Runs independent steps on a few threads.
#ifndef CAIRN_CORE_PARALLEL_FOR_H_
#define CAIRN_CORE_PARALLEL_FOR_H_

#include <functional>

namespace cairn {

// Calls step(0) ... step(count - 1) once each, in no particular order, on at most `num_threads`
// threads including the caller's. Returns when all steps are done. The first exception of a step
// prevents further steps from starting and is rethrown to the caller.
void ParallelFor(int count, int num_threads, const std::function<void(int)>& step);

}  // namespace cairn

#endif  // CAIRN_CORE_PARALLEL_FOR_H_
