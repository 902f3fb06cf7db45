// All experiments, in the paper's order.
#ifndef CAIRN_LAB_EXPERIMENTS_RUNS_EXPERIMENT_LIST_H_
#define CAIRN_LAB_EXPERIMENTS_RUNS_EXPERIMENT_LIST_H_

#include <string>
#include <vector>

#include "lab/experiments/experiment.h"

namespace cairn {

std::vector<Experiment> AllExperiments();

// Finds an experiment by its full name or its number ("07", "7"). Throws Error(kInvalidArgument)
// that lists the names.
Experiment FindExperiment(const std::string& name);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_RUNS_EXPERIMENT_LIST_H_
