#include "engine/query/localize_result.h"

namespace cairn {

const char* NotLocalizedReasonName(NotLocalizedReason reason) {
  switch (reason) {
    case NotLocalizedReason::kNone:
      return "NONE";
    case NotLocalizedReason::kNoCoverage:
      return "NO_COVERAGE";
    case NotLocalizedReason::kTooFewFeatures:
      return "TOO_FEW_FEATURES";
    case NotLocalizedReason::kTooFewMatches:
      return "TOO_FEW_MATCHES";
    case NotLocalizedReason::kTooFewInliers:
      return "TOO_FEW_INLIERS";
    case NotLocalizedReason::kAmbiguous:
      return "AMBIGUOUS";
    case NotLocalizedReason::kPriorMismatch:
      return "PRIOR_MISMATCH";
    case NotLocalizedReason::kTimeout:
      return "TIMEOUT";
  }
  return "UNKNOWN";
}

const char* StageName(Stage stage) {
  switch (stage) {
    case Stage::kPrior:
      return "prior";
    case Stage::kTiles:
      return "tiles";
    case Stage::kMatching:
      return "matching";
    case Stage::kVoting:
      return "voting";
    case Stage::kPose:
      return "pose";
    case Stage::kRefinement:
      return "refinement";
  }
  return "unknown";
}

}  // namespace cairn
