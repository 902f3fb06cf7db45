#include "lab/experiments/runs/runs.h"

namespace cairn {

ExperimentWorldOptions StandardWorld(const ExperimentContext& context) {
  ExperimentWorldOptions options;
  options.character = CityCharacter::kHighRise;
  options.size = context.Pick(CityWorldSize::kQuick, CityWorldSize::kMedium);
  options.num_queries = context.NumQueries(8, 200);
  options.hard_queries = true;
  options.seed = context.seed;
  return options;
}

}  // namespace cairn
