// What 16 and 17 share: recordings, and filter and bundle adjustment run on them; private to
// experiments.
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

// Among the methods; behind them come bundle adjustments.
inline constexpr size_t kFilter = 0;
inline constexpr size_t kSteadyFilter = 1;  // What the filter publishes for displays.

// The methods on some recordings of one kind.
struct FusionScene {
  std::string name;  // "grid city".
  std::vector<std::string> methods;
  std::vector<bool> is_steady;  // By method.
  // By recording, by method.
  std::vector<std::vector<fusion::MethodResult>> results;
};

// Walks in a city; and, where context.trajectories_folder is set, real trajectories under simulated
// cameras and maps. `variants` are the bundle adjustments; `steadies_rivals` adds what a display
// would show of each.
std::vector<FusionScene> RunFusionScenes(const ExperimentContext& context,
                                         const std::vector<fusion::RivalVariant>& variants,
                                         bool steadies_rivals);

ExperimentParameters FusionParameters(const ExperimentContext& context);

// Of one method on one recording; not a number where the method never had a pose.
using FusionMeasure = std::function<double(const fusion::MethodResult&)>;
double PositionRmseM(const fusion::MethodResult& result);
double RotationRmseDeg(const fusion::MethodResult& result);

// Mean over the recordings, with the bootstrap interval over them.
Interval MeanOver(const FusionScene& scene, size_t method, const FusionMeasure& measure);
// Mean of `method` over mean of `other`, likewise; not a number where that of `other` is not
// positive.
Interval RatioOver(const FusionScene& scene, size_t method, size_t other,
                   const FusionMeasure& measure);
// The bundle adjustment with the least mean; of the steadied ones, of which there must be some, or
// of the others.
size_t BestRival(const FusionScene& scene, const FusionMeasure& measure, bool is_steady = false);

// The measure of each method, a curve a scene; without steadied bundle adjustments, of which the
// tables tell.
Figure SceneFigure(const std::string& name, const std::string& title, const std::string& y_label,
                   const std::vector<FusionScene>& scenes, const FusionMeasure& measure);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_RUNS_FUSION_SCENES_H_
