// `cairn log`: lists the versions of a map.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "cli/arguments.h"
#include "cli/json_output.h"
#include "cli/shell.h"
#include "core/printable.h"
#include "http/json/version_json.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct LogArguments {
  std::string map_path;
  int64_t limit = std::numeric_limits<int64_t>::max();
  bool json = false;
};

void PrintVersionsAsJson(const std::vector<VersionRecord>& versions) {
  auto json = nlohmann::ordered_json::array();
  for (const VersionRecord& version : versions) {
    nlohmann::ordered_json one = VersionJson(version);
    one["author"] = version.author;
    json.push_back(std::move(one));
  }
  PrintJson(json);
}

void PrintText(const std::vector<VersionRecord>& versions) {
  for (const VersionRecord& version : versions) {
    fmt::print("{:<6} {}  {:<8} {}{}{}\n", Value(version.version), Excerpt(version.created_at),
               Excerpt(version.kind), Excerpt(version.session),
               version.session.empty() || version.summary.empty() ? "" : ": ",
               Excerpt(version.summary));
    fmt::print("       by {}; {} tiles, {} landmarks, {:.1f} kB\n", Excerpt(version.author),
               version.totals.num_tiles, version.totals.num_landmarks,
               1e-3 * static_cast<double>(version.totals.payload_bytes));
  }
}

ExitCode RunLog(const LogArguments& arguments) {
  const std::vector<VersionRecord> versions =
      MapStore::Open(arguments.map_path, OpenMode::kReadOnly).Snapshot().Versions(arguments.limit);
  if (arguments.json) {
    PrintVersionsAsJson(versions);
  } else {
    PrintText(versions);
  }
  return ExitCode::kOk;
}

}  // namespace

void AddLogCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("log", "List the versions of a map, newest first");
  auto arguments = std::make_shared<LogArguments>();
  command->add_option("MAP", arguments->map_path, "Map: a file or a postgresql:// URL")->required();
  command->add_option("--limit", arguments->limit, "Largest number of versions to list")
      ->check(PositiveNumber());
  AddJsonFlag(command, &arguments->json);
  command->footer("Example:\n  cairn log city.gpkg");
  command->callback(
      [shell, arguments] { shell->run = [arguments] { return RunLog(*arguments); }; });
}

}  // namespace cairn
