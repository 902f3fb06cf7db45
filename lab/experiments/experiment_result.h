// An experiment's outcome as it lies in a folder, and the report made of such files.
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
  std::string commit;  // Of the source that was built; "unknown" outside of a checkout.
  double seconds = 0.0;
  ExperimentParameters parameters;
  ResultTable table;
  std::vector<std::string> figures;  // Names; <name>.svg and <name>.png if they could be drawn.
  Verdict verdict = Verdict::kUndecided;
  std::string sentence;
};

// The commit that this library was built from, "-dirty" after it if files had been changed.
std::string BuildCommit();

std::string ResultAsJson(const ExperimentResult& result);
// Inverse of ResultAsJson. Throws Error(kBadInput) naming `what` if the text is something else.
ExperimentResult ResultFromJson(const std::string& text, const std::string& what);

// Runs the experiment and writes <name>.csv, <name>.json and, for each figure, <figure>.gp,
// <figure>.svg and <figure>.png into `folder`, which must exist. `*figures_drawn` is false if
// gnuplot is not there.
ExperimentResult RunExperiment(const Experiment& experiment, const ExperimentContext& context,
                               const std::string& folder, bool* figures_drawn);

// The results of the given experiments that lie in the folder, in their order; those that were not
// run are left out.
std::vector<ExperimentResult> ReadResults(const std::string& folder,
                                          const std::vector<Experiment>& experiments);

// docs/experiments.md: a summary of verdicts, then for each experiment claim, verdict, figure
// (`image_folder`/<figure>.svg), table and parameters. What depends on the machine comes last.
std::string ReportAsMarkdown(const std::vector<Experiment>& experiments,
                             const std::vector<ExperimentResult>& results,
                             const std::string& image_folder);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_EXPERIMENT_RESULT_H_
