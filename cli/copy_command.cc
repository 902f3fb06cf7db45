// `cairn copy`: copies a map, for example from a file to a PostgreSQL database.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/json_output.h"
#include "cli/shell.h"
#include "core/printable.h"
#include "storage/map/copy_map.h"

namespace cairn {
namespace {

struct CopyArguments {
  std::string from;
  std::string to;
  bool json = false;
};

ExitCode RunCopy(const CopyArguments& arguments, ProgressMode progress_mode) {
  MapInfo info;
  {
    Progress progress(progress_mode);
    info = CopyMap(arguments.from, arguments.to,
                   [&](int64_t done, int64_t total) { progress.Update("copy", done, total); });
  }
  if (arguments.json) {
    nlohmann::ordered_json json = {{"map", arguments.to}, {"mapVersion", Value(info.version)}};
    json.update(TotalsJson(info));
    PrintJson(json);
    return ExitCode::kOk;
  }
  fmt::print("{}: version {}, {} sessions, {} tiles, {} landmarks, {:.1f} kB\n",
             Printable(arguments.to), Value(info.version), info.num_sessions, info.num_tiles,
             info.num_landmarks, 1e-3 * static_cast<double>(info.payload_bytes));
  return ExitCode::kOk;
}

}  // namespace

void AddCopyCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand(
      "copy", "Copy a map with all its versions between files and PostgreSQL databases");
  auto arguments = std::make_shared<CopyArguments>();
  command->add_option("FROM", arguments->from, "Map: a file or a postgresql:// URL")->required();
  command->add_option("TO", arguments->to, "Map to create: a file or a postgresql:// URL")
      ->required();
  AddJsonFlag(command, &arguments->json);
  command->footer("Example:\n  cairn copy city.gpkg postgresql://builder@db1/city");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunCopy(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
