// What an experiment is: a question of the paper, asked of this engine in a simulated city.
#ifndef CAIRN_LAB_EXPERIMENTS_EXPERIMENT_H_
#define CAIRN_LAB_EXPERIMENTS_EXPERIMENT_H_

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "lab/experiments/experiment_world.h"
#include "lab/experiments/report/figure.h"
#include "lab/experiments/report/result_table.h"
#include "lab/experiments/report/verdict.h"

namespace cairn {

// Quick: seconds, to see that everything runs; its figures mean little. Full: minutes on two cores.
enum class ExperimentSize { kQuick, kFull };
const char* ExperimentSizeName(ExperimentSize size);  // "quick", "full".
// Throws Error(kInvalidArgument) that lists the names.
ExperimentSize ExperimentSizeFromName(const std::string& name);

using ExperimentProgress = std::function<void(const std::string& phase, int done, int total)>;

// What a run may use. The worlds are shared between experiments.
struct ExperimentContext {
  ExperimentSize size = ExperimentSize::kQuick;
  uint64_t seed = 1;
  int num_queries = 0;  // Of a world; 0: as many as the size asks for.
  int num_threads = 2;
  // Folder of the recordings of lab/recordings/room_recordings.h; empty: 16 and 17 walk in the city
  // only.
  std::string trajectories_folder;
  ExperimentWorlds* worlds = nullptr;
  ExperimentProgress progress;  // May be empty.

  // The parameter of this run's size.
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
  ExperimentParameters parameters;  // What was varied and held, for people.
  ResultTable table;
  std::vector<Figure> figures;
  Verdict verdict = Verdict::kUndecided;
  std::string sentence;  // Why the verdict, with the numbers.
};

struct Experiment {
  std::string name;   // "07_random_grids_vs_multi_index".
  std::string title;  // "Random grids against the inverted multi-index".
  std::string paper;  // Where the paper asks it: "Figure 8".
  std::string claim;  // What the paper says, in one sentence.
  // How the verdict is decided, in one sentence.
  std::string rule;
  // Of the full size on two idle cores; estimated from the CPU time of smaller runs.
  std::string full_duration;
  std::function<ExperimentOutcome(const ExperimentContext&)> run;
};

// The outcome of an experiment whose subject this build does not have.
ExperimentOutcome NotBuilt(const std::string& what_is_missing);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_EXPERIMENT_H_
