// Runs independent steps on a few threads.
#ifndef CAIRN_CORE_PARALLEL_FOR_H_
#define CAIRN_CORE_PARALLEL_FOR_H_

#include <functional>

namespace cairn {

// Calls step(0) ... step(count - 1), each once, in no particular order, on at most `num_threads`
// threads, the caller's among them. Returns when all are done; the first exception of a step stops
// the rest and is thrown again here.
void ParallelFor(int count, int num_threads, const std::function<void(int)>& step);

}  // namespace cairn

#endif  // CAIRN_CORE_PARALLEL_FOR_H_
