// `cairn prune`: deletes old versions of a map.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/json_output.h"
#include "cli/shell.h"
#include "storage/map/map_history.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct PruneArguments {
  std::string map_path;
  PruneOptions options;
  bool json = false;
};

// Completes a date such as "2026-01-31", which stands for the beginning of the day, UTC.
PruneOptions WithTime(PruneOptions options) {
  constexpr size_t kDateSize = 10;
  if (options.older_than && options.older_than->size() == kDateSize) {
    *options.older_than += "T00:00:00Z";
  }
  return options;
}

ExitCode RunPrune(const PruneArguments& arguments) {
  const PruneOptions options = WithTime(arguments.options);
  options.Validate();
  MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadWrite);
  const PruneReport report = Prune(options, &store);
  if (arguments.json) {
    PrintJson({{"mapVersion", Value(report.version)},
               {"versionsDeleted", report.num_versions_gone},
               {"payloadBytesDeleted", report.num_payload_bytes_gone}});
    return ExitCode::kOk;
  }
  fmt::print("deleted {} versions and {:.1f} kB of tiles; the map is now version {}\n",
             report.num_versions_gone, 1e-3 * static_cast<double>(report.num_payload_bytes_gone),
             Value(report.version));
  return ExitCode::kOk;
}

}  // namespace

void AddPruneCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("prune", "Delete old versions of a map");
  auto arguments = std::make_shared<PruneArguments>();
  command->add_option("MAP", arguments->map_path, "Map: a file or a postgresql:// URL")->required();
  command->add_option("--keep", arguments->options.keep,
                      "Number of versions to keep, counting the version that records the pruning");
  command->add_option("--older-than", arguments->options.older_than,
                      "Delete versions before this time: 2026-01-31 or 2026-01-31T12:00:00Z, UTC");
  AddJsonFlag(command, &arguments->json);
  command->footer(
      "The file keeps its size; cairn compact shrinks it.\n\n"
      "Example:\n  cairn prune city.gpkg --keep 10");
  command->callback(
      [shell, arguments] { shell->run = [arguments] { return RunPrune(*arguments); }; });
}

}  // namespace cairn
