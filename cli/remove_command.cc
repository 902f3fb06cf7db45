// `cairn remove`: removes a session from a map.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "cli/shell.h"
#include "core/printable.h"
#include "ingest/maps/remove_session.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct RemoveArguments {
  std::string map_path;
  std::string session_name;
};

ExitCode RunRemove(const RemoveArguments& arguments) {
  MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadWrite);
  const RemovalReport report = RemoveSession(arguments.session_name, &store);
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
  command->footer("Example:\n  cairn remove city.gpkg monday");
  command->callback(
      [shell, arguments] { shell->run = [arguments] { return RunRemove(*arguments); }; });
}

}  // namespace cairn
