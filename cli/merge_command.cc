// `cairn merge`: makes one map of two maps.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/join_summary.h"
#include "cli/json_output.h"
#include "cli/options_file.h"
#include "cli/session_arguments.h"
#include "cli/shell.h"
#include "core/parallel_for.h"
#include "core/printable.h"
#include "ingest/maps/merge_maps.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct MergeArguments {
  std::string a_path;
  std::string b_path;
  std::string out_path;
  bool apart = false;
  bool recode = false;
  bool force = false;
  bool json = false;
  CairnOptions options;
};

MapMergeOptions MergeOptionsOf(const MergeArguments& arguments) {
  const IngestOptions& ingest = arguments.options.ingest;
  MapMergeOptions options;
  options.joining = arguments.apart ? SessionJoining::kApart : SessionJoining::kJoin;
  options.recode = arguments.recode;
  options.selection = ingest.selection;
  options.appearance = ingest.appearance;
  options.agreement = ingest.agreement;
  options.gate = ingest.gate;
  if (arguments.force) {
    options.gate.max_lost_share = 1.0;
  }
  options.num_threads = NumCores();
  options.upkeep = ingest.upkeep;
  return options;
}

void PrintMergeAsJson(const MergeArguments& arguments, const MergeReport& report) {
  nlohmann::ordered_json json = {{"map", arguments.out_path}};
  json.update(TotalsJson(report.totals));
  json["tilesOfBoth"] = report.num_tiles_of_both;
  json["comparison"] = arguments.apart ? nullptr : ComparisonJson(report.comparison);
  json["changes"] = arguments.apart ? nullptr : ChangesJson(report.changes);
  json["keyframeAnswers"] = AnswersJson(report.keyframe_answers);
  PrintJson(json);
}

void PrintMerge(const MergeArguments& arguments, const MergeReport& report) {
  fmt::print("{}: {} sessions, {} tiles ({} of them in both maps), {} landmarks, {:.1f} kB\n",
             Printable(arguments.out_path), report.totals.num_sessions, report.totals.num_tiles,
             report.num_tiles_of_both, report.totals.num_landmarks,
             1e-3 * static_cast<double>(report.totals.payload_bytes));
  if (!arguments.apart && report.num_tiles_of_both > 0) {
    PrintComparison(report.comparison, "keyframes");
    fmt::print("landmarks        in the tiles of both maps:\n");
    PrintChanges(report.changes);
    fmt::print("tiles            {:.1f} kB in both maps, {:.1f} kB now\n",
               1e-3 * static_cast<double>(report.changes.num_bytes_before),
               1e-3 * static_cast<double>(report.changes.num_bytes_after));
  }
  PrintAnswers(report.keyframe_answers);
}

ExitCode RunMerge(const MergeArguments& arguments, ProgressMode progress_mode) {
  const MapStore a = MapStore::Open(arguments.a_path, OpenMode::kReadOnly);
  const MapStore b = MapStore::Open(arguments.b_path, OpenMode::kReadOnly);
  MergeReport report;
  {
    Progress progress(progress_mode);
    report = MergeMaps(a, b, arguments.out_path, MergeOptionsOf(arguments),
                       [&](int64_t done, int64_t total) { progress.Update("merge", done, total); });
  }
  const auto print = arguments.json ? PrintMergeAsJson : PrintMerge;
  print(arguments, report);
  return ExitCode::kOk;
}

}  // namespace

void AddMergeCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("merge", "Make one map of two maps");
  auto arguments = std::make_shared<MergeArguments>();
  command->add_option("A", arguments->a_path, "Map: a file or a postgresql:// URL")->required();
  command->add_option("B", arguments->b_path, "Map: a file or a postgresql:// URL")->required();
  command->add_option("--out", arguments->out_path, "Map file to create")->required();
  command->add_flag("--apart", arguments->apart,
                    "Do not compare the maps, and keep the landmarks of B beside those of A");
  command->add_flag("--recode", arguments->recode,
                    "If the codebooks differ, code B with the codebook of A on the way");
  AddForceFlag(command, &arguments->force);
  AddOptionsFile(command, &arguments->options);
  command
      ->add_option("--max-descriptors", arguments->options.ingest.selection.max_descriptors,
                   "Maximum number of descriptors of a tile that both maps have")
      ->capture_default_str();
  AddJsonFlag(command, &arguments->json);
  command->footer(
      "B joins A as its sessions would in an ingest: keyframes of B are localized in A, B moves "
      "to\n"
      "where A sees it, and landmarks that both know become one. Give the older map first.\n"
      "Example:\n"
      "  cairn merge north.gpkg south.gpkg --out city.gpkg");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunMerge(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
