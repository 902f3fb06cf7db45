// The stored outcome of an experiment, and the report made from such outcomes.
#ifndef CAIRN_LAB_EXPERIMENTS_EXPERIMENT_RESULT_H_
#define CAIRN_LAB_EXPERIMENTS_EXPERIMENT_RESULT_H_

#include <cstdint>
#include <string>
#include <vector>

#include "lab/experiments/experiment.h"

namespace cairn {

struct ExperimentResult {
  std::string name;
  ExperimentSize size = ExperimentSize::kQuick;
  uint64_t seed = 0;
  std::string commit;  // Commit of the built source; "unknown" outside a checkout.
  double seconds = 0.0;
  ExperimentParameters parameters;
  ResultTable table;
  std::vector<std::string> figures;  // <name>.svg and <name>.png exist if gnuplot could draw them.
  Verdict verdict = Verdict::kUndecided;
  std::string sentence;
};

std::string ResultAsJson(const ExperimentResult& result);
// Inverse of ResultAsJson. Throws Error(kBadInput) that names `what` if the text is not such a
// JSON.
ExperimentResult ResultFromJson(const std::string& text, const std::string& what);

// Runs the experiment and writes <name>.csv, <name>.json and, for each figure, <figure>.gp,
// <figure>.svg and <figure>.png to `folder`, which must exist. Sets `*figures_drawn` to false if
// gnuplot is not installed. `commit` is the one that the program was built from.
ExperimentResult RunExperiment(const Experiment& experiment, const ExperimentContext& context,
                               const std::string& commit, const std::string& folder,
                               bool* figures_drawn);

// Reads the results of the given experiments from the folder, in their order. Leaves out
// experiments without results.
std::vector<ExperimentResult> ReadResults(const std::string& folder,
                                          const std::vector<Experiment>& experiments);

// Returns docs/experiments.md: a summary of the verdicts, then each experiment's claim, verdict,
// figure (`image_folder`/<figure>.svg), table and parameters. Columns that depend on the machine
// come last.
std::string ReportAsMarkdown(const std::vector<Experiment>& experiments,
                             const std::vector<ExperimentResult>& results,
                             const std::string& image_folder);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_EXPERIMENT_RESULT_H_
