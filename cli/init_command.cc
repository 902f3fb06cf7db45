// `cairn init`: creates an empty map.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "cli/shell.h"
#include "storage/map/map_store.h"

namespace cairn {

void AddInitCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("init", "Create an empty map");
  auto map_path = std::make_shared<std::string>();
  command
      ->add_option("MAP", *map_path, "Map to create: a file, or the URL of a PostgreSQL database")
      ->required();
  command->footer("Example:\n  cairn init city.gpkg\n  cairn init postgresql://builder@db1/city");
  command->callback([shell, map_path] {
    shell->run = [map_path] {
      MapStore::Create(*map_path);
      return ExitCode::kOk;
    };
  });
}

}  // namespace cairn
