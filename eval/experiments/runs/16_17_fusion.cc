// The filter against bundle adjustment. Their comparison exists (fusion/rival/comparison.h); what
// it would be fed, answers of this engine along a simulated walk, does not.
#include "eval/experiments/runs/runs.h"

namespace cairn {
namespace {

constexpr const char* kMissing =
    "Walks through the simulated city are not yet localized and fed to the two estimators; "
    "cairn_fusion_rival_bench compares them on a simulation of its own.";

}  // namespace

Experiment EkfVsBundleAdjustmentExperiment() {
  return {
      "16_ekf_vs_bundle_adjustment",
      "The filter against bundle adjustment in a sliding window",
      "Table 2",
      "Including matches directly in the filter is as accurate in position as bundle adjustment "
      "in a sliding window, more accurate in orientation, and more than ten times as fast.",
      "",
      "",
      [](const ExperimentContext&) { return NotBuilt(kMissing); }};
}

Experiment SmoothnessExperiment() {
  return {"17_smoothness",
          "Smoothness of the fused trajectory",
          "Figure 17",
          "The filter's trajectory is significantly smoother than that of bundle adjustment in a "
          "sliding window.",
          "",
          "",
          [](const ExperimentContext&) { return NotBuilt(kMissing); }};
}

}  // namespace cairn
