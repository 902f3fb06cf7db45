// Map.localize_many: queries on several threads, their results in order.
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/error.h"
#include "python/arguments.h"
#include "python/docs.h"
#include "python/interruptible.h"
#include "python/map.h"

namespace cairn::python {
namespace {

// A query on its way to a thread and back.
struct Job {
  StatedQuery stated;
  PythonResult answer;
  std::exception_ptr failure;
  bool is_done = false;
};

// Threads that answer jobs in the order in which they come. Knows nothing of Python.
class AnswerPool {
 public:
  AnswerPool(std::shared_ptr<const OpenedMap> map, int num_threads) : map_(std::move(map)) {
    try {
      for (int i = 0; i < num_threads; ++i) {
        threads_.emplace_back([this] { Work(); });
      }
    } catch (...) {
      End();  // The threads that were made would wait for jobs, and their joins for them.
      throw;
    }
  }
  ~AnswerPool() { End(); }  // The threads are joined, each after the job at hand.

  void Add(std::shared_ptr<Job> job) {
    {
      const std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(job));
    }
    changed_.notify_all();
  }

  // Waits for a moment. Returns whether the job is done.
  bool WaitFor(const Job& job) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kSignalPeriod, [&] { return job.is_done; });
  }

 private:
  void End() {
    {
      const std::lock_guard lock(mutex_);
      is_ending_ = true;
      waiting_.clear();
    }
    changed_.notify_all();
  }

  void Work() {
    for (;;) {
      std::shared_ptr<Job> job;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return is_ending_ || !waiting_.empty(); });
        if (is_ending_) {
          return;
        }
        job = std::move(waiting_.front());
        waiting_.pop_front();
      }
      try {
        job->answer = map_->Answer(job->stated);
      } catch (...) {
        job->failure = std::current_exception();
      }
      {
        const std::lock_guard lock(mutex_);
        job->is_done = true;
      }
      changed_.notify_all();
    }
  }

  std::shared_ptr<const OpenedMap> map_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::shared_ptr<Job>> waiting_;
  bool is_ending_ = false;
  std::vector<std::jthread> threads_;  // Last, so that it ends first.
};

// The iterator of localize_many. At most two queries a thread are ahead of the one that is asked
// for, so that a long iterable takes little memory.
class ManyResults {
 public:
  ManyResults(std::shared_ptr<const OpenedMap> map, py::iterator queries, int num_threads)
      : pool_(std::make_shared<AnswerPool>(std::move(map), num_threads)),
        queries_(std::move(queries)),
        max_ahead_(2 * static_cast<size_t>(num_threads)) {}
  ~ManyResults() {
    const py::gil_scoped_release release;
    pool_.Reset();
  }

  PythonResult Next() {
    pool_.guard().Require("queries: this iterator of Map.localize_many");
    do {
      TakeAhead();
    } while (ahead_.empty() && !is_exhausted_);
    if (ahead_.empty()) {
      throw py::stop_iteration();
    }
    // Other threads of Python may come for the following ones while this one waits.
    const Entry next = std::move(ahead_.front());
    ahead_.pop_front();
    try {
      WaitFor(*next.job);
    } catch (...) {
      ahead_.push_front(next);  // A thread still looks at what it owns.
      throw;
    }
    if (next.job->failure) {
      std::rethrow_exception(next.job->failure);
    }
    return std::move(next.job->answer);
  }

 private:
  struct Entry {
    std::shared_ptr<Job> job = std::make_shared<Job>();
    std::vector<py::object> owners;
  };

  void WaitFor(const Job& job) {
    for (bool is_done = false; !is_done;) {
      {
        const py::gil_scoped_release release;
        is_done = pool_.get()->WaitFor(job);
      }
      ThrowOnSignal();
    }
  }

  // One thread at a time runs the iterable, which may be a generator. Other threads wait only if
  // nothing is ahead.
  void TakeAhead() {
    while (taker_ != std::thread::id() && ahead_.empty()) {
      if (taker_ == std::this_thread::get_id()) {
        RefuseArgument("queries", "waits for a result of the query that it is to give");
      }
      {
        const py::gil_scoped_release release;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      ThrowOnSignal();
    }
    if (taker_ != std::thread::id()) {
      return;
    }
    taker_ = std::this_thread::get_id();
    try {
      // No more than one filling, though other threads may take results meanwhile.
      for (size_t i = 0; i < max_ahead_ && ahead_.size() < max_ahead_ && !is_exhausted_; ++i) {
        TakeOne();
      }
    } catch (...) {
      taker_ = {};
      throw;
    }
    taker_ = {};
  }

  // An item that is no query fails when its turn comes, and so does an iterable that raises.
  void TakeOne() {
    const auto item = py::reinterpret_steal<py::object>(PyIter_Next(queries_.ptr()));
    if (!item) {
      is_exhausted_ = true;
      if (PyErr_Occurred() != nullptr) {
        AddFailureOfIterable(py::error_already_set());
      }
      return;
    }
    Entry entry;
    try {
      const PythonQuery query = QueryOf("queries", item);
      entry.job->stated = query.stated;
      entry.owners = query.owners;
      pool_.get()->Add(entry.job);
    } catch (const Error&) {
      entry.job->failure = std::current_exception();
      entry.job->is_done = true;
    }
    ahead_.push_back(std::move(entry));
  }

  // Ctrl-C, which is no Exception of Python, does not wait for the results before it.
  void AddFailureOfIterable(const py::error_already_set& error) {
    if (!error.matches(PyExc_Exception)) {
      throw py::error_already_set(error);
    }
    Entry entry;
    entry.job->failure = std::make_exception_ptr(error);
    entry.job->is_done = true;
    ahead_.push_back(std::move(entry));
  }

  // Destroyed from below: no thread of the pool looks at what the entries own, because the pool is
  // reset before.
  AtHome<AnswerPool> pool_;
  py::iterator queries_;
  std::deque<Entry> ahead_;
  size_t max_ahead_;
  std::thread::id taker_;  // That runs the iterable, if one does.
  bool is_exhausted_ = false;
};

std::unique_ptr<ManyResults> LocalizeMany(const PythonMap& map, const py::object& queries,
                                          const py::object& threads) {
  if (!py::isinstance<py::iterable>(queries) || IsPath(queries)) {
    RefuseArgument("queries", "must be an iterable of images, cairn.Features or cairn.Query");
  }
  return std::make_unique<ManyResults>(map.Require(), py::iter(queries),
                                       ThreadsOf("threads", threads));
}

}  // namespace

void BindMapBatches(py::module_* module, py::class_<PythonMap>* map) {
  using py::arg;
  py::class_<ManyResults>(*module, "ResultIterator", "The results of Map.localize_many, in order.")
      .def("__iter__", [](py::object self) { return self; })
      .def("__next__", &ManyResults::Next);
  map->def("localize_many", &LocalizeMany, arg("queries"), arg("threads") = 0, docs::kLocalizeMany);
}

}  // namespace cairn::python
