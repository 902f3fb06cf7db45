// An experiment: a question of the paper, answered for this engine in a simulated city.
#ifndef CAIRN_LAB_EXPERIMENTS_EXPERIMENT_H_
#define CAIRN_LAB_EXPERIMENTS_EXPERIMENT_H_

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "lab/experiments/experiment_world.h"
#include "lab/experiments/figure.h"
#include "lab/experiments/result_table.h"
#include "lab/experiments/verdict.h"

namespace cairn {

// kQuick takes seconds and checks that everything runs; its figures mean little. kFull takes
// minutes on two cores.
enum class ExperimentSize { kQuick, kFull };
const char* ExperimentSizeName(ExperimentSize size);  // "quick", "full".
// Throws Error(kInvalidArgument) that lists the names.
ExperimentSize ExperimentSizeFromName(const std::string& name);

using ExperimentProgress = std::function<void(const std::string& phase, int done, int total)>;

// The inputs of a run. Experiments share the worlds.
struct ExperimentContext {
  ExperimentSize size = ExperimentSize::kQuick;
  uint64_t seed = 1;
  int num_queries = 0;  // Per world; 0: the size decides.
  int num_threads = 2;
  // Folder of the recordings of eval/recordings/room_recordings.h. Empty: experiments 16 and 17 use
  // city walks only.
  std::string trajectories_folder;
  ExperimentWorlds* worlds = nullptr;
  ExperimentProgress progress;  // May be empty.

  // Returns the parameter for this run's size.
  template <typename Value>
  Value Pick(Value quick, Value full) const {
    return size == ExperimentSize::kQuick ? quick : full;
  }
  int NumQueries(int quick, int full) const {
    return num_queries > 0 ? num_queries : Pick(quick, full);
  }
};

using ExperimentParameters = std::vector<std::pair<std::string, std::string>>;

struct ExperimentOutcome {
  ExperimentParameters parameters;  // Settings that were varied or held, for readers.
  ResultTable table;
  std::vector<Figure> figures;
  Verdict verdict = Verdict::kUndecided;
  std::string sentence;  // The reason for the verdict, with numbers.
};

struct Experiment {
  std::string name;   // "07_random_grids_vs_multi_index".
  std::string title;  // "Random grids against the inverted multi-index".
  std::string paper;  // The paper's place of the question: "Figure 8".
  std::string claim;  // The paper's statement, in one sentence.
  // The rule that decides the verdict, in one sentence.
  std::string rule;
  // Duration of the full size on two idle cores, estimated from the CPU time of smaller runs.
  std::string full_duration;
  std::function<ExperimentOutcome(const ExperimentContext&)> run;
};

// Returns the outcome of an experiment whose subject is not in this build.
ExperimentOutcome NotBuilt(const std::string& what_is_missing);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_EXPERIMENT_H_
