// The experiments, one function for each. Private to experiments.
#ifndef CAIRN_LAB_EXPERIMENTS_RUNS_RUNS_H_
#define CAIRN_LAB_EXPERIMENTS_RUNS_RUNS_H_

#include "lab/experiments/experiment.h"

namespace cairn {

inline constexpr int kPaperNeighbors = 4;  // The k of the paper.

Experiment ObsVsIlpExperiment();
Experiment FixedDescriptorsExperiment();
Experiment DescriptorRatioExperiment();
Experiment FixedVsRatioExperiment();
Experiment DimensionAndQuantizationExperiment();
Experiment BucketLoadExperiment();
Experiment GridsVsMultiIndexExperiment();
Experiment PriorsExperiment();
Experiment NeighborsExperiment();
Experiment ThresholdOverCitiesExperiment();
Experiment RatioTestExperiment();
Experiment RansacIterationsExperiment();
Experiment VotingVsCovisibilityExperiment();
Experiment MinimalSolverExperiment();
Experiment RefinementExperiment();
Experiment EkfVsBundleAdjustmentExperiment();
Experiment SmoothnessExperiment();
Experiment FourCitiesExperiment();
Experiment CalibrationExperiment();
Experiment FirstCandidatesExperiment();
Experiment WrongGravityExperiment();
Experiment ElsewhereExperiment();
Experiment FocalLengthExperiment();
Experiment TwentySessionsExperiment();

// Returns the world that experiments 7 to 9, 11 to 15, 20 and 21 share.
ExperimentWorldOptions StandardWorld(const ExperimentContext& context);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_RUNS_RUNS_H_
