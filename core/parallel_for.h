// Runs independent steps on a few threads.
#ifndef CAIRN_CORE_PARALLEL_FOR_H_
#define CAIRN_CORE_PARALLEL_FOR_H_

#include <functional>

namespace cairn {

// Returns the number of cores of this machine, at least 1.
int NumCores();

// Calls step(0) ... step(count - 1) once each, on at most `num_threads` threads including the
// caller's; the others end with the call. Order, return and exceptions are as in
// SharedWorkers::ForEach.
void ParallelFor(int count, int num_threads, const std::function<void(int)>& step);

}  // namespace cairn

#endif  // CAIRN_CORE_PARALLEL_FOR_H_
