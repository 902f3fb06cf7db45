#include "python/interruptible.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

namespace cairn::python {
namespace {

struct Step {
  std::string phase;
  int64_t done = 0;
  int64_t total = 0;
};

// Ends the work from within; nothing else catches it.
class Interrupted {};

// What the work and the thread that waits for it share.
class Watch {
 public:
  // Of the work. The steps of a phase that nobody has taken yet become one.
  void Report(const char* phase, int64_t done, int64_t total) {
    const std::lock_guard lock(mutex_);
    if (is_stopped_) {
      throw Interrupted();
    }
    if (steps_.empty() || steps_.back().phase != phase) {
      steps_.emplace_back();
    }
    steps_.back() = {phase, done, total};
    changed_.notify_one();
  }

  void Finish(std::exception_ptr failure) {
    const std::lock_guard lock(mutex_);
    failure_ = std::move(failure);
    is_finished_ = true;
    changed_.notify_one();
  }

  // Of the waiting thread. Returns whether the work has ended.
  bool Wait(std::deque<Step>* steps) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kSignalPeriod, [&] { return is_finished_ || !steps_.empty(); });
    steps->swap(steps_);
    return is_finished_;
  }

  void Stop() {
    const std::lock_guard lock(mutex_);
    is_stopped_ = true;
  }

  const std::exception_ptr& failure() const { return failure_; }  // Once the work has ended.

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Step> steps_;
  std::exception_ptr failure_;
  bool is_stopped_ = false;
  bool is_finished_ = false;
};

void Follow(const py::object& progress, Watch* watch) {
  for (bool is_finished = false; !is_finished;) {
    std::deque<Step> steps;
    {
      const py::gil_scoped_release release;
      is_finished = watch->Wait(&steps);
    }
    ThrowOnSignal();
    for (const Step& step : steps) {
      if (!progress.is_none()) {
        progress(step.phase, step.done, step.total);
      }
    }
  }
}

// Waits for the end of work that shall stop.
void StopAndWait(const std::function<void()>& stop, Watch* watch) {
  const py::gil_scoped_release release;
  watch->Stop();
  std::deque<Step> ignored;
  do {
    if (stop) {
      stop();
    }
    ignored.clear();
  } while (!watch->Wait(&ignored));
}

}  // namespace

void ThrowOnSignal() {
  if (PyErr_CheckSignals() != 0) {
    throw py::error_already_set();
  }
}

void RunInterruptibly(const py::object& progress,
                      const std::function<void(const WorkProgress& report)>& work,
                      const std::function<void()>& stop) {
  if (!progress.is_none() && PyCallable_Check(progress.ptr()) == 0) {
    RefuseArgument("progress", "must be a function of phase, done and total");
  }
  Watch watch;
  std::jthread thread([&] {
    std::exception_ptr failure;
    try {
      work([&](const char* phase, int64_t done, int64_t total) {
        watch.Report(phase, done, total);
      });
    } catch (const Interrupted&) {
    } catch (...) {
      failure = std::current_exception();
    }
    watch.Finish(failure);
  });
  try {
    Follow(progress, &watch);
  } catch (...) {
    StopAndWait(stop, &watch);
    throw;
  }
  thread.join();
  if (watch.failure()) {
    std::rethrow_exception(watch.failure());
  }
}

}  // namespace cairn::python
