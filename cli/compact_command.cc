// `cairn compact`: rewrites a map file without its free space.
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

struct CompactArguments {
  std::string map_path;
  bool json = false;
};

int64_t FileBytes(const MapStore& store) { return store.Snapshot().Info().file_bytes; }

ExitCode RunCompact(const CompactArguments& arguments) {
  MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadWrite);
  const int64_t before = FileBytes(store);
  CompactMap(&store);
  const int64_t after = FileBytes(store);
  if (arguments.json) {
    PrintJson({{"fileBytesBefore", before}, {"fileBytes", after}});
    return ExitCode::kOk;
  }
  fmt::print("{:.1f} kB before, {:.1f} kB now\n", 1e-3 * static_cast<double>(before),
             1e-3 * static_cast<double>(after));
  return ExitCode::kOk;
}

}  // namespace

void AddCompactCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("compact", "Rewrite a map file without its free space");
  auto arguments = std::make_shared<CompactArguments>();
  command->add_option("MAP", arguments->map_path, "Map file")->required();
  AddJsonFlag(command, &arguments->json);
  command->footer("Example:\n  cairn compact city.gpkg");
  command->callback(
      [shell, arguments] { shell->run = [arguments] { return RunCompact(*arguments); }; });
}

}  // namespace cairn
