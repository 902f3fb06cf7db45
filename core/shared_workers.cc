#include "core/shared_workers.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace cairn {
namespace {

// One call of ForEach.
struct Job {
  const std::function<void(int)>& step;
  int count = 0;
  int next = 0;         // Index of the step that starts next.
  int num_running = 0;  // Number of running steps.
  int failed = 0;       // Index of the step that threw `failure`.
  std::exception_ptr failure;

  bool has_started_all() const { return next >= count; }
  bool is_done() const { return has_started_all() && num_running == 0; }
};

}  // namespace

struct SharedWorkers::Impl {
  const int num_threads;
  std::mutex mutex;  // Guards all members below except the threads.
  std::condition_variable work_changed;
  std::condition_variable job_done;
  std::deque<Job*> jobs;  // Jobs that still have steps to start.
  int num_callers = 0;
  int num_helping = 0;
  bool is_stopping = false;
  std::vector<std::thread> helpers;

  explicit Impl(int threads) : num_threads(threads) {
    for (int i = 1; i < num_threads; ++i) {
      helpers.emplace_back([this] { Help(); });
    }
  }

  bool CanHelp() const { return !jobs.empty() && num_callers + num_helping < num_threads; }

  // Runs the next step of a job, which must have one. Releases the lock while the step runs.
  void RunStep(Job* job, std::unique_lock<std::mutex>* lock) {
    const int index = job->next++;
    ++job->num_running;
    if (job->has_started_all()) {
      std::erase(jobs, job);
    }
    lock->unlock();
    std::exception_ptr failure;
    try {
      job->step(index);
    } catch (...) {
      failure = std::current_exception();
    }
    lock->lock();
    --job->num_running;
    if (failure && (!job->failure || index < job->failed)) {
      job->failure = failure;
      job->failed = index;
      job->next = job->count;
      std::erase(jobs, job);
    }
    if (job->is_done()) {
      job_done.notify_all();
    }
  }

  // The loop of a helper thread.
  void Help() {
    std::unique_lock<std::mutex> lock(mutex);
    while (true) {
      work_changed.wait(lock, [this] { return is_stopping || CanHelp(); });
      if (is_stopping) {
        return;
      }
      Job* job = jobs.front();
      std::rotate(jobs.begin(), jobs.begin() + 1, jobs.end());
      ++num_helping;
      RunStep(job, &lock);
      --num_helping;
    }
  }
};

SharedWorkers::SharedWorkers(int num_threads)
    : impl_(std::make_unique<Impl>(std::max(1, num_threads))) {}

SharedWorkers::~SharedWorkers() {
  {
    const std::lock_guard<std::mutex> lock(impl_->mutex);
    impl_->is_stopping = true;
  }
  impl_->work_changed.notify_all();
  for (std::thread& helper : impl_->helpers) {
    helper.join();
  }
}

SharedWorkers::Caller::Caller(SharedWorkers* workers) : workers_(workers) {
  const std::lock_guard<std::mutex> lock(workers_->impl_->mutex);
  ++workers_->impl_->num_callers;
}

SharedWorkers::Caller::~Caller() {
  {
    const std::lock_guard<std::mutex> lock(workers_->impl_->mutex);
    --workers_->impl_->num_callers;
  }
  workers_->impl_->work_changed.notify_one();
}

int SharedWorkers::NumFree() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return std::max(1, impl_->num_threads - std::max(1, impl_->num_callers) - impl_->num_helping + 1);
}

void SharedWorkers::ForEach(int count, const std::function<void(int)>& step) {
  if (count <= 0) {
    return;
  }
  Job job{.step = step, .count = count, .failure = nullptr};
  std::unique_lock<std::mutex> lock(impl_->mutex);
  if (count > 1) {
    impl_->jobs.push_back(&job);
    impl_->work_changed.notify_all();
  }
  while (!job.has_started_all()) {
    impl_->RunStep(&job, &lock);
  }
  impl_->job_done.wait(lock, [&job] { return job.is_done(); });
  if (job.failure) {
    std::rethrow_exception(job.failure);
  }
}

void ForEachStep(SharedWorkers* workers, int count, const std::function<void(int)>& step) {
  if (workers != nullptr) {
    workers->ForEach(count, step);
    return;
  }
  for (int i = 0; i < count; ++i) {
    step(i);
  }
}

}  // namespace cairn
