// Long work that Ctrl-C stops.
#ifndef CAIRN_PYTHON_INTERRUPTIBLE_H_
#define CAIRN_PYTHON_INTERRUPTIBLE_H_

#include <chrono>
#include <cstdint>
#include <functional>

#include "python/errors.h"

namespace cairn::python {

using WorkProgress = std::function<void(const char* phase, int64_t done, int64_t total)>;

// How often a waiting thread of Python looks for signals.
inline constexpr std::chrono::milliseconds kSignalPeriod{50};

// Throws the pending exception if the handler of a signal has raised one, as Ctrl-C's does. Needs
// the GIL.
void ThrowOnSignal();

// Runs `work` on a thread of its own, without the GIL. The calling thread waits, passes what the
// work reports to `progress(phase, done, total)` unless that is None, and looks for signals. If a
// signal or `progress` raises, the next report of the work throws, so that the work ends where it
// can; then the exception goes on. `stop`, if given, is called again and again until the work ends.
// Throws Error(kInvalidArgument) if `progress` cannot be called. Needs the GIL.
void RunInterruptibly(const py::object& progress,
                      const std::function<void(const WorkProgress& report)>& work,
                      const std::function<void()>& stop = {});

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_INTERRUPTIBLE_H_
