// `cairn merge`: makes one map of two maps.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "cli/shell.h"
#include "core/printable.h"
#include "ingest/merge_maps.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct MergeArguments {
  std::string a_path;
  std::string b_path;
  std::string out_path;
};

ExitCode RunMerge(const MergeArguments& arguments, ProgressMode progress_mode) {
  const MapStore a = MapStore::Open(arguments.a_path, OpenMode::kReadOnly);
  const MapStore b = MapStore::Open(arguments.b_path, OpenMode::kReadOnly);
  MergeReport report;
  {
    Progress progress(progress_mode);
    report = MergeMaps(a, b, arguments.out_path,
                       [&](int64_t done, int64_t total) { progress.Update("merge", done, total); });
  }
  fmt::print("{}: {} sessions, {} tiles ({} of them in both maps), {} landmarks, {:.1f} kB\n",
             Printable(arguments.out_path), report.totals.num_sessions, report.totals.num_tiles,
             report.num_tiles_of_both, report.totals.num_landmarks,
             1e-3 * static_cast<double>(report.totals.payload_bytes));
  return ExitCode::kOk;
}

}  // namespace

void AddMergeCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("merge", "Make one map of two maps of one codebook");
  auto arguments = std::make_shared<MergeArguments>();
  command->add_option("A", arguments->a_path, "Map file")->required();
  command->add_option("B", arguments->b_path, "Map file")->required();
  command->add_option("--out", arguments->out_path, "Map file to create")->required();
  command->footer("Example:\n  cairn merge north.gpkg south.gpkg --out city.gpkg");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunMerge(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
