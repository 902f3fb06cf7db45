// `cairn check`: checks every page and tile of a map for damage.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/json_output.h"
#include "cli/shell.h"
#include "core/error.h"
#include "core/printable.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct CheckArguments {
  std::string map_path;
  bool json = false;
};

constexpr size_t kMaxProblemBytes = 1000;

// Says that earlier versions have further contents of tiles, which are checked, too.
std::string EarlierContents(int64_t num_contents) {
  return num_contents > 0
             ? fmt::format(" and {} earlier contents of tiles in its versions", num_contents)
             : "";
}

// What --json prints, whether or not there are problems.
void PrintCheckAsJson(const MapStore& store, const CheckReport& report) {
  const MapSnapshot snapshot = store.Snapshot();
  nlohmann::ordered_json problems = nlohmann::ordered_json::array();
  for (const std::string& problem : report.problems) {
    problems.push_back(Excerpt(problem, kMaxProblemBytes));
  }
  PrintJson({{"version", Value(snapshot.version())},
             {"contentsOfTilesChecked", report.num_tiles_checked},
             {"sound", report.problems.empty()},
             {"problems", std::move(problems)}});
}

void PrintProblems(const CheckReport& report) {
  for (const std::string& problem : report.problems) {
    fmt::print("{}\n", Excerpt(problem, kMaxProblemBytes));
  }
}

void PrintSound(const CheckArguments& arguments, const MapStore& store, const CheckReport& report) {
  const int64_t num_tiles = store.Snapshot().Info().num_tiles;
  fmt::print("{}: {} tiles{}, no problems\n", Printable(arguments.map_path), num_tiles,
             EarlierContents(report.num_tiles_checked - num_tiles));
}

ExitCode RunCheck(const CheckArguments& arguments, ProgressMode progress_mode) {
  const MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadOnly);
  CheckReport report;
  {
    Progress progress(progress_mode);
    report =
        store.Check([&](int64_t done, int64_t total) { progress.Update("check", done, total); });
  }
  if (arguments.json) {
    PrintCheckAsJson(store, report);
  } else {
    PrintProblems(report);
  }
  if (!report.problems.empty()) {
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("{}: {} problems found; restore the file from a copy or ingest the "
                            "sessions into a new map",
                            arguments.map_path, report.problems.size()));
  }
  if (!arguments.json) {
    PrintSound(arguments, store, report);
  }
  return ExitCode::kOk;
}

}  // namespace

void AddCheckCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("check", "Check every page and tile of a map for damage");
  auto arguments = std::make_shared<CheckArguments>();
  command->add_option("MAP", arguments->map_path, "Map: a file or a postgresql:// URL")->required();
  AddJsonFlag(command, &arguments->json);
  command->footer("Example:\n  cairn check city.gpkg");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunCheck(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
