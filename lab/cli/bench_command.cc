// `cairn-lab bench`: measures a query stage by stage, on one core and a map of the paper's size.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "cli/arguments.h"
#include "cli/index_option.h"
#include "cli/options_file.h"
#include "core/error.h"
#include "lab/bench/bench_world.h"
#include "lab/bench/run_bench.h"
#include "lab/cli/lab_verbs.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct BenchArguments {
  BenchWorldOptions world;
  RunBenchOptions run;
  CairnOptions options;
};

// A folder that is removed at the end.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "cairn_bench_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) {
      throw Error(ErrorCode::kIo, pattern + ": " + std::strerror(errno));
    }
    path_ = pattern;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string File(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

void PrintTimes(const std::string& name, const Percentiles& seconds) {
  fmt::print("{:<12} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f}\n", name, 1e3 * seconds.p50,
             1e3 * seconds.p90, 1e3 * seconds.p99, 1e3 * seconds.max);
}

// Prints a load time relative to a plain read of the tile's bytes.
void PrintLoad(const char* name, double seconds, const BenchFigures& figures) {
  fmt::print("{:<18} {:.2f} ms, {:.1f} times a plain read\n", name, 1e3 * seconds,
             seconds / figures.plain_read_seconds);
}

// Mean of a counter over the answers.
double Mean(const EvalReport& report, int64_t StageCounters::*counter) {
  double sum = 0.0;
  for (const EvalAnswer& answer : report.answers) {
    sum += static_cast<double>(answer.result.counters.*counter);
  }
  return sum / static_cast<double>(std::max<size_t>(1, report.answers.size()));
}

void Print(const BenchWorldOptions& world, const BenchFigures& figures) {
  fmt::print("Warm query with {} keypoints against {} cached tiles, {} descriptors; one core, ms\n",
             world.num_keypoints, figures.num_tiles, figures.num_descriptors);
  fmt::print("{:<12} {:>9} {:>9} {:>9} {:>9}\n", "stage", "median", "90 %", "99 %", "max");
  for (int stage = 0; stage < kNumStages; ++stage) {
    PrintTimes(StageName(static_cast<Stage>(stage)), figures.warm.stage_seconds[stage]);
  }
  PrintTimes("total", figures.warm.total_seconds);
  fmt::print("\nright answers      {} of {}\n", figures.num_right, figures.warm.num_queries);
  fmt::print("tiles searched     {:.1f} per query\n",
             Mean(figures.warm, &StageCounters::num_tiles_searched));
  fmt::print("distances          {:.0f} per query\n",
             Mean(figures.warm, &StageCounters::num_distances));
  fmt::print("matches            {:.0f} per query\n",
             Mean(figures.warm, &StageCounters::num_matches));
  fmt::print("cold tile load     {:.1f} ms per tile until the tile can be searched\n",
             1e3 * figures.cold_tile_seconds);
  PrintLoad("tile load", figures.tile_load_seconds, figures);
  PrintLoad("  of which blob", figures.blob_load_seconds, figures);
  fmt::print("cold query         {:.1f} ms with no tile in the cache\n",
             1e3 * figures.cold_query_seconds);
  fmt::print("tile               {:.2f} MB in the file, {:.2f} MB in the cache\n",
             1e-6 * figures.payload_bytes_per_tile, 1e-6 * figures.cached_bytes_per_tile);
  fmt::print("exhaustive search  {:.1f} ms for all keypoints of one query\n",
             1e3 * figures.exhaustive_seconds);
  fmt::print(
      "descriptor space   {:.3f} between observations of a landmark, {:.3f} to other landmarks\n",
      figures.same_landmark_distance, figures.other_landmark_distance);
}

ExitCode RunBenchCommand(const BenchArguments& arguments, ProgressMode progress_mode) {
  const ScratchFolder scratch;
  const std::string map_path = scratch.File("bench.gpkg");
  std::vector<EvalQuery> queries;
  {
    Progress progress(progress_mode);
    queries = BuildBenchWorld(arguments.world, map_path, [&](int done, int total) {
      progress.Update("building tiles", done, total);
    });
  }
  const auto store =
      std::make_shared<const MapStore>(MapStore::Open(map_path, OpenMode::kReadOnly));
  RunBenchOptions run = arguments.run;
  run.localizer = arguments.options.localizer;
  run.localizer.seed = arguments.world.seed;
  const BenchFigures figures = RunBench(store, queries, run);
  Print(arguments.world, figures);
  if (figures.num_right < figures.warm.num_queries) {
    throw Error(
        ErrorCode::kInternal,
        fmt::format("{} of {} answers are wrong, so the times above are meaningless",
                    figures.warm.num_queries - figures.num_right, figures.warm.num_queries));
  }
  return ExitCode::kOk;
}

}  // namespace

void AddBenchCommand(CLI::App* app, Shell* shell) {
  CLI::App* command =
      app->add_subcommand("bench", "Measure the stages of a query on a synthetic map");
  auto arguments = std::make_shared<BenchArguments>();
  BenchWorldOptions& world = arguments->world;
  AddOptionsFile(command, &arguments->options);
  command->add_option("--keypoints", world.num_keypoints, "Keypoints per query")
      ->capture_default_str();
  command
      ->add_option("--tiles", world.num_tiles,
                   "Number of tiles: 1, 2 or 4; every query touches all")
      ->capture_default_str();
  command
      ->add_option("--landmarks", world.landmarks_per_tile,
                   "Landmarks per tile, with 2.5 descriptors each")
      ->capture_default_str();
  command->add_option("--queries", world.num_queries, "Number of different queries")
      ->capture_default_str();
  command->add_option("--repeats", arguments->run.num_repeats, "Repeats of each query")
      ->capture_default_str();
  AddIndexOption(command, &arguments->options.localizer.matching.index.kind);
  AddSeedOption(command, &world.seed, "Seed of the map, the queries and the localizer");
  command->footer(
      "Fails if an answer is wrong.\n"
      "Example:\n"
      "  cairn-lab bench --keypoints 1000 --tiles 4 --landmarks 200000");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunBenchCommand(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
