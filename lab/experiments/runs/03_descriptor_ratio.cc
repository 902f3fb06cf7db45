// A ratio of each landmark's descriptors: k-means, k-medoids, random.
#include "lab/experiments/runs/appearance_runs.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

ExperimentOutcome Run(const ExperimentContext& context) {
  return CompareKinds(context, "03_descriptor_ratio", "A ratio of the descriptors", "ratio",
                      context.Pick<std::vector<double>>({0.1, 0.5}, {0.1, 0.25, 0.5}),
                      RatioVariant);
}

}  // namespace

Experiment DescriptorRatioExperiment() {
  return {
      "03_descriptor_ratio",
      "A ratio of the descriptors per landmark",
      "Figure 4",
      "Keeping a fraction of each landmark's descriptors, centres of k-means serve better than "
      "those of k-medoids or a random choice.",
      "holds if the average precision of k-means, in the mean over ratios, is greater than that "
      "of k-medoids and that of a random choice, each by a paired interval; does not hold if it "
      "is smaller than one.",
      "8 min",
      Run};
}

}  // namespace cairn
