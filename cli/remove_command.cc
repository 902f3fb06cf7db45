// `cairn remove`: removes a session from a map.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/json_output.h"
#include "cli/shell.h"
#include "core/printable.h"
#include "ingest/maps/remove_session.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct RemoveArguments {
  std::string map_path;
  std::string session_name;
  bool json = false;
};

void PrintRemovalAsJson(const RemoveArguments& arguments, const RemovalReport& report) {
  PrintJson({{"session", arguments.session_name},
             {"mapVersion", Value(report.map_version)},
             {"landmarksRemoved", report.num_landmarks_removed},
             {"landmarksShared", report.num_landmarks_shared},
             {"tilesRewritten", report.num_tiles_rewritten},
             {"tilesRemoved", report.num_tiles_removed}});
}

void PrintRemoval(const RemoveArguments& arguments, const RemovalReport& report) {
  fmt::print("removed session {}; the map now has version {}\n", Excerpt(arguments.session_name),
             Value(report.map_version));
  fmt::print(
      "{} landmarks are gone. {} landmarks that other sessions saw, too, keep its share in their "
      "positions and descriptors.\n",
      report.num_landmarks_removed, report.num_landmarks_shared);
  if (report.num_landmarks_shared > 0) {
    fmt::print(
        "If the sessions were archived (cairn ingest --archive), cairn rebuild --without makes a "
        "map in which the session has never been.\n");
  }
  if (report.num_tiles_removed > 0) {
    fmt::print(
        "{} tiles are gone, since no other session has a keyframe there; cairn rollback brings an "
        "earlier version back.\n",
        report.num_tiles_removed);
  }
}

ExitCode RunRemove(const RemoveArguments& arguments) {
  MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadWrite);
  const RemovalReport report = RemoveSession(arguments.session_name, &store);
  const auto print = arguments.json ? PrintRemovalAsJson : PrintRemoval;
  print(arguments, report);
  return ExitCode::kOk;
}

}  // namespace

void AddRemoveCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("remove", "Remove a session from a map");
  auto arguments = std::make_shared<RemoveArguments>();
  command->add_option("MAP", arguments->map_path, "Map: a file or a postgresql:// URL")->required();
  command
      ->add_option("SESSION", arguments->session_name,
                   "Name of the session, as listed by cairn info")
      ->required();
  AddJsonFlag(command, &arguments->json);
  command->footer("Example:\n  cairn remove city.gpkg monday");
  command->callback(
      [shell, arguments] { shell->run = [arguments] { return RunRemove(*arguments); }; });
}

}  // namespace cairn
