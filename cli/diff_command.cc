// `cairn diff`: shows the tiles that differ between two versions of a map.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/json_output.h"
#include "cli/shell.h"
#include "core/error.h"
#include "http/json/tile_square.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

struct DiffArguments {
  std::string map_path;
  int64_t from = 0;  // 0: the version before `to`.
  int64_t to = 0;    // 0: the latest.
  bool json = false;
  bool geojson = false;
};

// Sums over the tiles that differ.
struct DiffSums {
  int64_t num_added = 0;
  int64_t num_removed = 0;
  int64_t num_replaced = 0;
  int64_t landmarks = 0;  // After minus before.
  int64_t bytes = 0;      // After minus before.
};

const char* KindOf(const TileChange& change) {
  if (!change.before) {
    return "added";
  }
  return change.after ? "replaced" : "removed";
}

DiffSums SumUp(const std::vector<TileChange>& changes) {
  DiffSums sums;
  for (const TileChange& change : changes) {
    const TileState before = change.before.value_or(TileState());
    const TileState after = change.after.value_or(TileState());
    sums.num_added += change.before ? 0 : 1;
    sums.num_removed += change.after ? 0 : 1;
    sums.num_replaced += change.before && change.after ? 1 : 0;
    sums.landmarks += after.num_landmarks - before.num_landmarks;
    sums.bytes += after.num_bytes - before.num_bytes;
  }
  return sums;
}

Json StateJson(const std::optional<TileState>& state) {
  if (!state) {
    return nullptr;
  }
  return {
      {"digest", state->digest}, {"landmarks", state->num_landmarks}, {"bytes", state->num_bytes}};
}

Json ChangeJson(const TileChange& change) {
  return {{"tile", change.tile_id.ToString()},
          {"change", KindOf(change)},
          {"before", StateJson(change.before)},
          {"after", StateJson(change.after)}};
}

void PrintGeoJson(const std::vector<TileChange>& changes) {
  Json features = Json::array();
  for (const TileChange& change : changes) {
    features.push_back({{"type", "Feature"},
                        {"id", change.tile_id.ToString()},
                        {"geometry", TileSquareJson(change.tile_id)},
                        {"properties", ChangeJson(change)}});
  }
  fmt::print("{}\n", Json({{"type", "FeatureCollection"}, {"features", features}}).dump(2));
}

void PrintChangesAsJson(const DiffArguments& arguments, const std::vector<TileChange>& changes) {
  const DiffSums sums = SumUp(changes);
  Json tiles = Json::array();
  for (const TileChange& change : changes) {
    tiles.push_back(ChangeJson(change));
  }
  fmt::print("{}\n", Json({{"from", arguments.from},
                           {"to", arguments.to},
                           {"tilesAdded", sums.num_added},
                           {"tilesReplaced", sums.num_replaced},
                           {"tilesRemoved", sums.num_removed},
                           {"landmarks", sums.landmarks},
                           {"bytes", sums.bytes},
                           {"tiles", tiles}})
                         .dump(2));
}

void PrintText(const DiffArguments& arguments, const std::vector<TileChange>& changes) {
  fmt::print("version {} -> {}\n", arguments.from, arguments.to);
  for (const TileChange& change : changes) {
    const TileState before = change.before.value_or(TileState());
    const TileState after = change.after.value_or(TileState());
    fmt::print("{}  {:<8}  {} -> {} landmarks, {} -> {} bytes\n", change.tile_id.ToString(),
               KindOf(change), before.num_landmarks, after.num_landmarks, before.num_bytes,
               after.num_bytes);
  }
  const DiffSums sums = SumUp(changes);
  fmt::print("{} tiles added, {} replaced, {} removed; {:+} landmarks, {:+} bytes\n",
             sums.num_added, sums.num_replaced, sums.num_removed, sums.landmarks, sums.bytes);
}

// Fills in the versions that were not given: the last update.
void ChooseVersions(const MapSnapshot& snapshot, DiffArguments* arguments) {
  if (arguments->to == 0) {
    arguments->to = Value(snapshot.version());
  }
  if (arguments->from != 0) {
    return;
  }
  const std::vector<VersionRecord> newest = snapshot.Versions(2);
  if (newest.size() < 2) {
    throw Error(ErrorCode::kNotFound,
                fmt::format("{}: the map has no version before {} to compare with; see cairn log",
                            arguments->map_path, arguments->to));
  }
  arguments->from = Value(newest[1].version);
}

ExitCode RunDiff(DiffArguments arguments) {
  const MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadOnly);
  const MapSnapshot snapshot = store.Snapshot();
  ChooseVersions(snapshot, &arguments);
  const std::vector<TileChange> changes =
      snapshot.Diff(MapVersion(arguments.from), MapVersion(arguments.to));
  if (arguments.geojson) {
    PrintGeoJson(changes);
  } else if (arguments.json) {
    PrintChangesAsJson(arguments, changes);
  } else {
    PrintText(arguments, changes);
  }
  return ExitCode::kOk;
}

}  // namespace

void AddDiffCommand(CLI::App* app, Shell* shell) {
  CLI::App* command =
      app->add_subcommand("diff", "Show the tiles that differ between two versions");
  auto arguments = std::make_shared<DiffArguments>();
  command->add_option("MAP", arguments->map_path, "Map: a file or a postgresql:// URL")->required();
  command
      ->add_option("FROM", arguments->from,
                   "Earlier version; see cairn log. Default: the version before the latest")
      ->check(CLI::PositiveNumber);
  command->add_option("TO", arguments->to, "Later version. Default: the latest")
      ->check(CLI::PositiveNumber);
  CLI::Option* json = AddJsonFlag(command, &arguments->json);
  command->add_flag("--geojson", arguments->geojson, "Print the squares of the tiles as GeoJSON")
      ->excludes(json);
  command->footer("Example:\n  cairn diff city.gpkg\n  cairn diff city.gpkg 3 5");
  command->callback(
      [shell, arguments] { shell->run = [arguments] { return RunDiff(*arguments); }; });
}

}  // namespace cairn
