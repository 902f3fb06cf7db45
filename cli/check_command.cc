// `cairn check`: checks every page and tile of a map for damage.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "cli/shell.h"
#include "core/error.h"
#include "core/printable.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

constexpr size_t kMaxProblemBytes = 1000;

// Says that earlier versions have further contents of tiles, which are checked, too.
std::string EarlierContents(int64_t num_contents) {
  return num_contents > 0
             ? fmt::format(" and {} earlier contents of tiles in its versions", num_contents)
             : "";
}

ExitCode RunCheck(const std::string& map_path, ProgressMode progress_mode) {
  const MapStore store = MapStore::Open(map_path, OpenMode::kReadOnly);
  CheckReport report;
  {
    Progress progress(progress_mode);
    report =
        store.Check([&](int64_t done, int64_t total) { progress.Update("check", done, total); });
  }
  for (const std::string& problem : report.problems) {
    fmt::print("{}\n", Excerpt(problem, kMaxProblemBytes));
  }
  if (!report.problems.empty()) {
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("{}: {} problems found; restore the file from a copy or ingest the "
                            "sessions into a new map",
                            map_path, report.problems.size()));
  }
  const int64_t num_tiles = store.Snapshot().Info().num_tiles;
  fmt::print("{}: {} tiles{}, no problems\n", Printable(map_path), num_tiles,
             EarlierContents(report.num_tiles_checked - num_tiles));
  return ExitCode::kOk;
}

}  // namespace

void AddCheckCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("check", "Check every page and tile of a map for damage");
  auto map_path = std::make_shared<std::string>();
  command->add_option("MAP", *map_path, "Map: a file or a postgresql:// URL")->required();
  command->footer("Example:\n  cairn check city.gpkg");
  command->callback([shell, map_path] {
    shell->run = [shell, map_path] { return RunCheck(*map_path, shell->progress_mode); };
  });
}

}  // namespace cairn
