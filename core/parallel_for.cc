#include "core/parallel_for.h"

#include <algorithm>

#include "core/shared_workers.h"

namespace cairn {

void ParallelFor(int count, int num_threads, const std::function<void(int)>& step) {
  SharedWorkers(std::min(num_threads, count)).ForEach(count, step);
}

}  // namespace cairn
