// Compares k-means, k-medoids and random choice for a ratio of each landmark's descriptors.
#include "lab/experiments/runs/appearance_runs.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

ExperimentOutcome RunDescriptorRatio(const ExperimentContext& context) {
  return CompareKinds(context, "03_descriptor_ratio", "A ratio of the descriptors", "ratio",
                      context.Pick<std::vector<double>>({0.1, 0.5}, {0.1, 0.25, 0.5}),
                      RatioVariant);
}

}  // namespace

Experiment DescriptorRatioExperiment() {
  return {"03_descriptor_ratio",
          "A ratio of the descriptors per landmark",
          "Figure 4",
          "If a fraction of each landmark's descriptors is kept, the centers of k-means give "
          "better answers than those of k-medoids or a random choice.",
          "holds if k-means, in the mean over ratios, has a higher average precision than "
          "k-medoids and than a random choice, each by a paired interval; does not hold if k-means "
          "is worse than one of them.",
          "8 min",
          RunDescriptorRatio};
}

}  // namespace cairn
