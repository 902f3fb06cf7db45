// `cairn-lab experiment`: runs the paper's experiments and reports their results.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "cli/arguments.h"
#include "cli/choice_option.h"
#include "core/error.h"
#include "core/file_bytes.h"
#include "lab/cli/lab_verbs.h"
#include "lab/experiments/experiment_result.h"
#include "lab/experiments/runs/experiment_list.h"

namespace cairn {
namespace {

struct ExperimentArguments {
  std::vector<std::string> names;
  std::string size = "quick";
  std::string out_folder = "experiments";
  std::string report_path = "docs/experiments.md";
  uint64_t seed = 1;
  int num_queries = 0;
  int num_threads = 2;
  std::string trajectories_folder;
};

void MakeFolder(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) {
    throw Error(ErrorCode::kIo, path.string() + ": " + error.message());
  }
}

ExitCode List() {
  fmt::print("{:<30} {:<21} {:<6} {}\n", "name", "paper", "full", "question");
  for (const Experiment& experiment : AllExperiments()) {
    fmt::print("{:<30} {:<21} {:<6} {}\n", experiment.name, experiment.paper,
               experiment.full_duration.empty() ? "-" : experiment.full_duration, experiment.title);
  }
  return ExitCode::kOk;
}

// Writes the report page and the figures that it shows beside it.
ExitCode Report(const ExperimentArguments& arguments) {
  const std::vector<Experiment> experiments = AllExperiments();
  const std::vector<ExperimentResult> results = ReadResults(arguments.out_folder, experiments);
  if (results.empty()) {
    throw Error(ErrorCode::kNotFound, arguments.out_folder +
                                          ": no results; run `cairn-lab experiment all --out " +
                                          arguments.out_folder + "` first");
  }
  const std::string image_folder = "images/experiments";
  const std::filesystem::path report(arguments.report_path);
  const std::filesystem::path images = report.parent_path() / image_folder;
  MakeFolder(images);
  for (const ExperimentResult& result : results) {
    for (const std::string& figure : result.figures) {
      const std::string file = figure + ".svg";
      std::error_code error;
      std::filesystem::copy_file(std::filesystem::path(arguments.out_folder) / file, images / file,
                                 std::filesystem::copy_options::overwrite_existing, error);
      if (error) {
        throw Error(ErrorCode::kIo, file + ": " + error.message() + "; is gnuplot installed?");
      }
    }
  }
  WriteTextFile(report.string(), ReportAsMarkdown(experiments, results, image_folder));
  fmt::print("{} experiments in {}\n", results.size(), report.string());
  return ExitCode::kOk;
}

// Returns the named experiments in the paper's order, each once.
std::vector<Experiment> Chosen(const std::vector<std::string>& names) {
  std::vector<std::string> wanted;
  for (const std::string& name : names) {
    wanted.push_back(name == "all" ? name : FindExperiment(name).name);
  }
  std::vector<Experiment> chosen;
  for (const Experiment& experiment : AllExperiments()) {
    const auto is_wanted = [&](const std::string& name) {
      return name == "all" || name == experiment.name;
    };
    if (std::any_of(wanted.begin(), wanted.end(), is_wanted)) {
      chosen.push_back(experiment);
    }
  }
  return chosen;
}

ExitCode Run(const ExperimentArguments& arguments, const Shell& shell) {
  const std::vector<Experiment> chosen = Chosen(arguments.names);
  const std::filesystem::path out(arguments.out_folder);
  MakeFolder(out);
  ExperimentWorlds worlds((out / "worlds").string());
  ExperimentContext context;
  context.size = ExperimentSizeFromName(arguments.size);
  context.seed = arguments.seed;
  context.num_queries = arguments.num_queries;
  context.num_threads = arguments.num_threads;
  context.trajectories_folder = arguments.trajectories_folder;
  context.worlds = &worlds;
  for (const Experiment& experiment : chosen) {
    bool figures_drawn = true;
    ExperimentResult result;
    {
      Progress progress(shell.progress_mode);
      context.progress = [&](const std::string& phase, int done, int total) {
        progress.Update(experiment.name + ": " + phase, done, total);
      };
      result = RunExperiment(experiment, context, shell.commit.empty() ? "unknown" : shell.commit,
                             out.string(), &figures_drawn);
    }
    fmt::print("{}: {}\n{}\n", result.name, VerdictName(result.verdict), result.sentence);
    if (!figures_drawn) {
      fmt::print("gnuplot did not draw the figures; the scripts are {}/*.gp\n", out.string());
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
  return ExitCode::kOk;
}

ExitCode RunExperimentCommand(const ExperimentArguments& arguments, const Shell& shell) {
  if (arguments.num_threads < 1 || arguments.num_queries < 0) {
    throw Error(ErrorCode::kInvalidArgument,
                "--threads must be at least 1, and --queries must not be negative");
  }
  if (arguments.names.size() == 1 && arguments.names.front() == "list") {
    return List();
  }
  if (arguments.names.size() == 1 && arguments.names.front() == "report") {
    return Report(arguments);
  }
  return Run(arguments, shell);
}

}  // namespace

void AddExperimentCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand(
      "experiment", "Run the paper's experiments on this engine in a simulated city");
  auto arguments = std::make_shared<ExperimentArguments>();
  command
      ->add_option("what", arguments->names,
                   "Names or numbers of experiments; or list, all or report")
      ->required()
      ->type_name("list|all|report|NAME...");
  AddWordOption(
      command, "--size", {"quick", "full"},
      [arguments](const std::string& word) { arguments->size = word; },
      "quick: seconds, but the figures mean little; full: minutes per experiment")
      ->default_str(arguments->size);
  command->add_option("--out", arguments->out_folder, "Folder for results and worlds")
      ->capture_default_str();
  command->add_option("--to", arguments->report_path, "Page to write with report")
      ->capture_default_str();
  AddSeedOption(command, &arguments->seed, "Seed of the cities, the queries and the localizer");
  command
      ->add_option("--queries", arguments->num_queries,
                   "Queries per world; fewer are faster but decide less (0: the size decides)")
      ->capture_default_str();
  command->add_option("--threads", arguments->num_threads, "Queries to measure in parallel")
      ->capture_default_str();
  command
      ->add_option("--trajectories", arguments->trajectories_folder,
                   "Folder with real inertial samples for experiments 16 and 17: "
                   "euroc_V1_01_easy/mav0 (in EuRoC's layout), vi_imu_gt/euroc_V1_02_medium and "
                   "vi_imu_gt/tumvi_room1 (imu.csv, groundtruth.csv)")
      ->check(CLI::ExistingDirectory);
  command->footer(
      "Examples:\n"
      "  cairn-lab experiment list\n"
      "  cairn-lab experiment 07 --size full --out results\n"
      "  cairn-lab experiment all --size full --out results\n"
      "  cairn-lab experiment report --out results --to docs/experiments.md");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunExperimentCommand(*arguments, *shell); };
  });
}

}  // namespace cairn
