// The cities of different character that experiments 10 and 18 compare. Private to experiments.
#ifndef CAIRN_LAB_EXPERIMENTS_RUNS_CITIES_H_
#define CAIRN_LAB_EXPERIMENTS_RUNS_CITIES_H_

#include <string>
#include <utility>
#include <vector>

#include "lab/experiments/experiment.h"

namespace cairn {

// Returns the name and the world of each city.
std::vector<std::pair<std::string, ExperimentWorldOptions>> Cities(
    const ExperimentContext& context);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_RUNS_CITIES_H_
