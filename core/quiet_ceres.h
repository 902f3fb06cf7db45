// Ceres without its messages. For targets that link Ceres.
#ifndef CAIRN_CORE_QUIET_CERES_H_
#define CAIRN_CORE_QUIET_CERES_H_

#include <ceres/solver.h>
#include <glog/logging.h>

#include <mutex>

namespace cairn {

// Returns options under which Ceres prints nothing. It would warn on the standard error of each
// step that fails, after which it tries a shorter one. A program that has initialized glog keeps
// its own limit.
inline ceres::Solver::Options QuietCeresOptions() {
  static std::once_flag is_done;
  std::call_once(is_done, [] {
    if (!google::IsGoogleLoggingInitialized()) {
      FLAGS_minloglevel = google::GLOG_ERROR;
    }
  });
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace cairn

#endif  // CAIRN_CORE_QUIET_CERES_H_
