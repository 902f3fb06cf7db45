// `cairn rollback`: publishes the content of an earlier version again.
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

struct RollbackArguments {
  std::string map_path;
  int64_t version = 0;
  bool json = false;
};

ExitCode RunRollback(const RollbackArguments& arguments) {
  MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadWrite);
  const MapVersion version = RollBack(MapVersion(arguments.version), &store);
  if (arguments.json) {
    PrintJson({{"mapVersion", Value(version)}, {"contentOfVersion", arguments.version}});
    return ExitCode::kOk;
  }
  fmt::print("the map is now version {}, with the content of version {}\n", Value(version),
             arguments.version);
  return ExitCode::kOk;
}

}  // namespace

void AddRollbackCommand(CLI::App* app, Shell* shell) {
  CLI::App* command =
      app->add_subcommand("rollback", "Publish the content of an earlier version again");
  auto arguments = std::make_shared<RollbackArguments>();
  command->add_option("MAP", arguments->map_path, "Map: a file or a postgresql:// URL")->required();
  command->add_option("VERSION", arguments->version, "Version; see cairn log")->required();
  AddJsonFlag(command, &arguments->json);
  command->footer("Example:\n  cairn rollback city.gpkg 3");
  command->callback(
      [shell, arguments] { shell->run = [arguments] { return RunRollback(*arguments); }; });
}

}  // namespace cairn
