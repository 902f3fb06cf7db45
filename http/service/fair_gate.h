// Lets as many threads compute at once as there are cores, in order of arrival.
#ifndef CAIRN_HTTP_SERVICE_FAIR_GATE_H_
#define CAIRN_HTTP_SERVICE_FAIR_GATE_H_

#include <chrono>
#include <condition_variable>
#include <list>
#include <mutex>

namespace cairn {

// With more concurrent queries than cores, every query would run in small slices and finish after
// its deadline. In a queue, the queries at the front finish in time. Safe to call from any thread.
class FairGate {
 public:
  explicit FairGate(int num_slots) : num_free_(num_slots) {}

  // Waits in line for a slot. Returns false if the deadline passes first. After true, the caller
  // must call Leave.
  bool Enter(std::chrono::steady_clock::time_point deadline);
  void Leave();

  int num_waiting() const;

 private:
  struct Waiter {
    std::condition_variable admitted;
    bool is_admitted = false;
  };

  mutable std::mutex mutex_;
  int num_free_;                // 0 while a thread waits.
  std::list<Waiter*> waiters_;  // In order of arrival.
};

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_FAIR_GATE_H_
