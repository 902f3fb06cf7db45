#include "lab/experiments/experiment.h"

#include "core/error.h"

namespace cairn {

const char* ExperimentSizeName(ExperimentSize size) {
  return size == ExperimentSize::kQuick ? "quick" : "full";
}

ExperimentSize ExperimentSizeFromName(const std::string& name) {
  for (const ExperimentSize size : {ExperimentSize::kQuick, ExperimentSize::kFull}) {
    if (name == ExperimentSizeName(size)) {
      return size;
    }
  }
  throw Error(ErrorCode::kInvalidArgument,
              "there is no size '" + name + "'; sizes are quick and full");
}

ExperimentOutcome NotBuilt(const std::string& what_is_missing) {
  ExperimentOutcome outcome;
  outcome.verdict = Verdict::kNotBuilt;
  outcome.sentence = what_is_missing;
  return outcome;
}

}  // namespace cairn
