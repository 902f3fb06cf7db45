#include "core/parallel_for.h"

#include <algorithm>
#include <thread>

#include "core/shared_workers.h"

namespace cairn {

int NumCores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

void ParallelFor(int count, int num_threads, const std::function<void(int)>& step) {
  SharedWorkers(std::min(num_threads, count)).ForEach(count, step);
}

}  // namespace cairn
