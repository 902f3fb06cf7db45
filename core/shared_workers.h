// Threads that all queries of a localizer share.
#ifndef CAIRN_CORE_SHARED_WORKERS_H_
#define CAIRN_CORE_SHARED_WORKERS_H_

#include <functional>
#include <memory>

namespace cairn {

// The callers' threads and the helpers together never exceed the number of threads. A query that
// runs alone gets help from all helpers. If there are as many queries as threads, each runs on its
// caller's thread and the helpers rest. Safe to call from any thread.
class SharedWorkers {
 public:
  // `num_threads` is the number of threads that work at once, including the callers'; the
  // constructor starts one helper fewer. `num_threads` is at least 1, which starts no helper.
  explicit SharedWorkers(int num_threads);
  ~SharedWorkers();  // No call may be running.

  // While a Caller lives, its thread computes, and the helpers leave one core to it.
  class Caller {
   public:
    explicit Caller(SharedWorkers* workers);
    ~Caller();
    Caller(const Caller&) = delete;
    Caller& operator=(const Caller&) = delete;

   private:
    SharedWorkers* workers_;
  };

  // Returns how many threads would work on a ForEach that started now; at least 1.
  int NumFree() const;

  // Calls step(0) ... step(count - 1) once each, on the calling thread and on idle helpers. Steps
  // start in this order. Helpers serve callers in turn, one step at a time. Returns when all steps
  // are done. An exception prevents further steps from starting. The exception of the failed step
  // with the lowest index is rethrown to the caller, on any number of threads the same one. Steps
  // must not call ForEach.
  void ForEach(int count, const std::function<void(int)>& step);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Calls SharedWorkers::ForEach. If `workers` is null, runs all steps on the calling thread.
void ForEachStep(SharedWorkers* workers, int count, const std::function<void(int)>& step);

}  // namespace cairn

#endif  // CAIRN_CORE_SHARED_WORKERS_H_
