#include "lab/experiments/runs/experiment_list.h"

#include "core/error.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

// Returns "07" for "7" and "07".
std::string TwoDigits(const std::string& name) { return name.size() == 1 ? "0" + name : name; }

}  // namespace

std::vector<Experiment> AllExperiments() {
  return {ObsVsIlpExperiment(),
          FixedDescriptorsExperiment(),
          DescriptorRatioExperiment(),
          FixedVsRatioExperiment(),
          DimensionAndQuantizationExperiment(),
          BucketLoadExperiment(),
          GridsVsMultiIndexExperiment(),
          PriorsExperiment(),
          NeighborsExperiment(),
          ThresholdOverCitiesExperiment(),
          RatioTestExperiment(),
          RansacIterationsExperiment(),
          VotingVsCovisibilityExperiment(),
          MinimalSolverExperiment(),
          RefinementExperiment(),
          EkfVsBundleAdjustmentExperiment(),
          SmoothnessExperiment(),
          FourCitiesExperiment(),
          CalibrationExperiment(),
          FirstCandidatesExperiment(),
          WrongGravityExperiment(),
          ElsewhereExperiment(),
          FocalLengthExperiment(),
          TwentySessionsExperiment()};
}

Experiment FindExperiment(const std::string& name) {
  std::string names;
  for (const Experiment& experiment : AllExperiments()) {
    if (experiment.name == name ||
        experiment.name.substr(0, experiment.name.find('_')) == TwoDigits(name)) {
      return experiment;
    }
    names += "\n  " + experiment.name;
  }
  throw Error(ErrorCode::kInvalidArgument,
              "there is no experiment '" + name + "'; experiments are:" + names);
}

}  // namespace cairn
