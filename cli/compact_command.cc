// `cairn compact`: rewrites a map file without its free space.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "cli/shell.h"
#include "storage/map/map_history.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

double FileKb(const MapStore& store) {
  return 1e-3 * static_cast<double>(store.Snapshot().Info().file_bytes);
}

ExitCode RunCompact(const std::string& map_path) {
  MapStore store = MapStore::Open(map_path, OpenMode::kReadWrite);
  const double before_kb = FileKb(store);
  CompactMap(&store);
  fmt::print("{:.1f} kB before, {:.1f} kB now\n", before_kb, FileKb(store));
  return ExitCode::kOk;
}

}  // namespace

void AddCompactCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("compact", "Rewrite a map file without its free space");
  auto map_path = std::make_shared<std::string>();
  command->add_option("MAP", *map_path, "Map file")->required();
  command->footer("Example:\n  cairn compact city.gpkg");
  command->callback(
      [shell, map_path] { shell->run = [map_path] { return RunCompact(*map_path); }; });
}

}  // namespace cairn
