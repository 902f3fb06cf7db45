// Lets as many threads compute at once as there are cores, first come, first served.
#ifndef CAIRN_HTTP_SERVICE_FAIR_GATE_H_
#define CAIRN_HTTP_SERVICE_FAIR_GATE_H_

#include <chrono>
#include <condition_variable>
#include <list>
#include <mutex>

namespace cairn {

// More queries at once than cores make all of them late: each would be served in small slices, and
// by the time they are done their deadlines have passed. In line, those that have come first are
// done in time. Safe to call from any thread.
class FairGate {
 public:
  explicit FairGate(int num_slots) : num_free_(num_slots) {}

  // Waits in line for a slot; false if the deadline passes first. True obliges to Leave.
  bool Enter(std::chrono::steady_clock::time_point deadline);
  void Leave();

  int num_waiting() const;

 private:
  struct Waiter {
    std::condition_variable admitted;
    bool is_admitted = false;
  };

  mutable std::mutex mutex_;
  int num_free_;                // 0 while somebody waits.
  std::list<Waiter*> waiters_;  // In order of arrival.
};

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_FAIR_GATE_H_
