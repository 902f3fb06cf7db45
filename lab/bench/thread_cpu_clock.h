// Processor time of the calling thread. Other load on the machine hardly affects it.
#ifndef CAIRN_LAB_BENCH_THREAD_CPU_CLOCK_H_
#define CAIRN_LAB_BENCH_THREAD_CPU_CLOCK_H_

#include <ctime>

namespace cairn {

inline double ThreadCpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace cairn

#endif  // CAIRN_LAB_BENCH_THREAD_CPU_CLOCK_H_
