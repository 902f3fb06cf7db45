// Keeps objects with threads, locks and open files from being used in a forked process, which has
// none of the threads and shares the files.
#ifndef CAIRN_PYTHON_PROCESS_GUARD_H_
#define CAIRN_PYTHON_PROCESS_GUARD_H_

#include <unistd.h>

#include <memory>
#include <string>
#include <utility>

#include "core/error.h"

namespace cairn::python {

class ProcessGuard {
 public:
  bool is_at_home() const { return getpid() == home_; }

  // Throws Error(kConflict) "<what> ..." in any process but that of the constructor.
  void Require(const std::string& what) const {
    if (!is_at_home()) {
      throw Error(ErrorCode::kConflict, what +
                                            " belongs to the process that made it, and this is a "
                                            "fork of it; make another one here");
    }
  }

 private:
  pid_t home_ = getpid();
};

// Owns a value that only its own process destroys: its threads are not there to be joined in
// another.
template <typename T>
class AtHome {
 public:
  explicit AtHome(std::shared_ptr<T> value) : value_(std::move(value)) {}
  AtHome(const AtHome&) = delete;
  AtHome& operator=(const AtHome&) = delete;
  ~AtHome() { Reset(); }

  const std::shared_ptr<T>& get() const { return value_; }
  const ProcessGuard& guard() const { return guard_; }

  void Reset() {
    if (!guard_.is_at_home()) {
      new std::shared_ptr<T>(std::move(value_));  // Never destroyed, on purpose.
    }
    value_.reset();
  }

 private:
  ProcessGuard guard_;
  std::shared_ptr<T> value_;
};

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_PROCESS_GUARD_H_
