// Ceres without its messages. For targets that link Ceres.
#ifndef CAIRN_CORE_ADJUST_QUIET_CERES_H_
#define CAIRN_CORE_ADJUST_QUIET_CERES_H_

#include <ceres/solver.h>
#include <glog/logging.h>

#include <algorithm>
#include <mutex>

namespace cairn {

// Returns options without messages of progress. The first call also raises glog's limit to errors
// for the whole process, unless the program has initialized glog before. Ceres would otherwise
// print a warning of each step that it cannot compute, although it then tries a shorter one.
inline ceres::Solver::Options QuietCeresOptions() {
  static std::once_flag is_done;
  std::call_once(is_done, [] {
    if (!google::IsGoogleLoggingInitialized()) {
      FLAGS_minloglevel = std::max<int>(FLAGS_minloglevel, google::GLOG_ERROR);
    }
  });
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace cairn

#endif  // CAIRN_CORE_ADJUST_QUIET_CERES_H_
