// Threads that all queries of a localizer share.
#ifndef CAIRN_CORE_SHARED_WORKERS_H_
#define CAIRN_CORE_SHARED_WORKERS_H_

#include <functional>
#include <memory>

namespace cairn {

// A query that is alone gets help from as many threads as there are; queries that come at once get
// a thread each, their callers', and the helpers rest. Safe to call from any thread.
class SharedWorkers {
 public:
  // `num_threads` is how many work at once, the callers' among them: one helper less is started.
  // At least 1, which starts none.
  explicit SharedWorkers(int num_threads);
  ~SharedWorkers();  // No call may be running.

  // Announces, while it lives, that its thread computes: so long the helpers leave it a core.
  class Caller {
   public:
    explicit Caller(SharedWorkers* workers);
    ~Caller();
    Caller(const Caller&) = delete;
    Caller& operator=(const Caller&) = delete;

   private:
    SharedWorkers* workers_;
  };

  // How many threads would work on a ForEach that started now; at least 1.
  int NumFree() const;

  // Calls step(0) ... step(count - 1), each once, on the calling thread and on helpers that are
  // free; they start in this order. Helpers serve callers in turn, one step each. Returns when all
  // are done; the first exception keeps the steps that have not started from starting and is thrown
  // again here. Steps must not call ForEach.
  void ForEach(int count, const std::function<void(int)>& step);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// SharedWorkers::ForEach, or, without workers (null), all steps on the calling thread.
void ForEachStep(SharedWorkers* workers, int count, const std::function<void(int)>& step);

}  // namespace cairn

#endif  // CAIRN_CORE_SHARED_WORKERS_H_
