// Shared code of experiments 16 and 17: recordings, and runs of the filter and bundle adjustment on
// them. Private to experiments.
#ifndef CAIRN_LAB_EXPERIMENTS_RUNS_FUSION_SCENES_H_
#define CAIRN_LAB_EXPERIMENTS_RUNS_FUSION_SCENES_H_

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "eval/evaluation_bootstrap.h"
#include "lab/experiments/experiment.h"
#include "lab/rivals/fusion/comparison.h"

namespace cairn {

// Index of the filter among the methods. The bundle adjustments follow.
inline constexpr size_t kFilter = 0;
inline constexpr size_t kSteadyFilter = 1;  // The poses that the filter publishes for displays.

// The methods on several recordings of one kind.
struct FusionScene {
  std::string name;  // "grid city".
  std::vector<std::string> methods;
  std::vector<bool> is_steady;  // Indexed by method.
  // Indexed by recording, then by method.
  std::vector<std::vector<fusion::MethodResult>> results;
};

// Runs the methods on walks in a city and, if context.trajectories_folder is set, on real
// trajectories under simulated cameras and maps. `variants` are the bundle adjustments.
// `steadies_rivals` adds the poses that a display would show of each.
std::vector<FusionScene> RunFusionScenes(const ExperimentContext& context,
                                         const std::vector<fusion::RivalVariant>& variants,
                                         bool steadies_rivals);

ExperimentParameters FusionParameters(const ExperimentContext& context);

// A measure of one method on one recording. NaN if the method never had a pose.
using FusionMeasure = std::function<double(const fusion::MethodResult&)>;
double PositionRmseM(const fusion::MethodResult& result);
double RotationRmseDeg(const fusion::MethodResult& result);

// Returns the mean over the recordings with its bootstrap interval.
Interval MeanOver(const FusionScene& scene, size_t method, const FusionMeasure& measure);
// Returns the mean of `method` divided by the mean of `other`, with its bootstrap interval. NaN if
// the mean of `other` is not positive.
Interval RatioOver(const FusionScene& scene, size_t method, size_t other,
                   const FusionMeasure& measure);
// Returns the bundle adjustment with the smallest mean. `is_steady` selects among the smoothed
// ones, of which there must be some, or among the others.
size_t BestRival(const FusionScene& scene, const FusionMeasure& measure, bool is_steady = false);

// Judges every scene. `judge` appends what it says about a scene to the sentence.
Verdict JudgeScenes(const std::vector<FusionScene>& scenes,
                    const std::function<Verdict(const FusionScene&, std::string*)>& judge,
                    std::string* sentence);

// Draws the measure of each method, one curve per scene. Leaves out smoothed bundle adjustments,
// which are in the tables.
Figure SceneFigure(const std::string& name, const std::string& title, const std::string& y_label,
                   const std::vector<FusionScene>& scenes, const FusionMeasure& measure);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_RUNS_FUSION_SCENES_H_
