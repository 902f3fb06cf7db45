// Experiments whose subject is not there yet.
#include "eval/experiments/runs/runs.h"

namespace cairn {

Experiment ObsVsIlpExperiment() {
  return {"01_obs_vs_ilp",
          "Observation count against integer programming",
          "Figure 2",
          "For the same memory, landmarks chosen by integer programming serve better than those "
          "chosen by their number of observations.",
          "",
          "",
          [](const ExperimentContext&) {
            return NotBuilt("Selection of landmarks by integer programming is not in this build.");
          }};
}

Experiment FixedDescriptorsExperiment() {
  return {"02_fixed_descriptors",
          "A fixed number of descriptors per landmark",
          "Figure 3",
          "Centres of k-means serve better than those of k-medoids or a random choice, and memory "
          "can be reduced by some 40 % at a moderate loss.",
          "",
          "",
          [](const ExperimentContext&) {
            return NotBuilt("Summarization by k-medoids and random choice is not in this build.");
          }};
}

Experiment DescriptorRatioExperiment() {
  return {"03_descriptor_ratio",
          "A ratio of the descriptors per landmark",
          "Figure 4",
          "Keeping a fraction of each landmark's descriptors, centres of k-means serve better than "
          "those of k-medoids or a random choice.",
          "",
          "",
          [](const ExperimentContext&) {
            return NotBuilt("Summarization by k-medoids and random choice is not in this build.");
          }};
}

Experiment FixedVsRatioExperiment() {
  return {"04_fixed_vs_ratio",
          "Fixed number against ratio of descriptors",
          "Figure 5",
          "For most operating points the difference between a fixed number and a ratio of "
          "descriptors is marginal.",
          "",
          "",
          [](const ExperimentContext&) {
            return NotBuilt("Summarization to a fixed number is not in this build.");
          }};
}

Experiment EkfVsBundleAdjustmentExperiment() {
  return {
      "16_ekf_vs_bundle_adjustment",
      "The filter against bundle adjustment in a sliding window",
      "Table 2",
      "Including matches directly in the filter is as accurate in position as bundle adjustment "
      "in a sliding window, more accurate in orientation, and more than ten times as fast.",
      "",
      "",
      [](const ExperimentContext&) {
        return NotBuilt("The fusion library and its rival are not in this build.");
      }};
}

Experiment SmoothnessExperiment() {
  return {"17_smoothness",
          "Smoothness of the fused trajectory",
          "Figure 17",
          "The filter's trajectory is significantly smoother than that of bundle adjustment in a "
          "sliding window.",
          "",
          "",
          [](const ExperimentContext&) {
            return NotBuilt("The fusion library and its rival are not in this build.");
          }};
}

}  // namespace cairn
