// `cairn extract`: copies a part of a map into a new map.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/geojson_region.h"
#include "cli/json_output.h"
#include "cli/shell.h"
#include "core/printable.h"
#include "storage/map/extract_map.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct ExtractArguments {
  std::string map_path;
  std::string box;
  std::string geojson_path;
  std::string out_path;
  bool json = false;
};

GeoRegion RegionOf(const ExtractArguments& arguments) {
  if (arguments.box.empty()) {
    return ReadGeoJsonRegion(arguments.geojson_path);
  }
  const std::vector<double> box = ParseNumbers("--bbox", arguments.box, 4);
  return GeoRegion::OfBox(box[0], box[1], box[2], box[3]);
}

ExitCode RunExtract(const ExtractArguments& arguments) {
  const GeoRegion region = RegionOf(arguments);
  const MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadOnly);
  const MapTotals totals = ExtractMap(store, region, arguments.out_path);
  if (arguments.json) {
    nlohmann::ordered_json json = {{"map", arguments.out_path}};
    json.update(TotalsJson(totals));
    PrintJson(json);
    return ExitCode::kOk;
  }
  fmt::print("{}: {} sessions, {} tiles, {} landmarks, {:.1f} kB\n", Printable(arguments.out_path),
             totals.num_sessions, totals.num_tiles, totals.num_landmarks,
             1e-3 * static_cast<double>(totals.payload_bytes));
  return ExitCode::kOk;
}

}  // namespace

void AddExtractCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("extract", "Copy the tiles of a region into a new map");
  auto arguments = std::make_shared<ExtractArguments>();
  command->add_option("MAP", arguments->map_path, "Map: a file or a postgresql:// URL")->required();
  CLI::Option_group* region = command->add_option_group("region");
  region->add_option("--bbox", arguments->box, "south,west,north,east in degrees");
  region->add_option("--geojson", arguments->geojson_path, "GeoJSON file of polygons");
  region->require_option(1);
  command->add_option("--out", arguments->out_path, "Map file to create")->required();
  AddJsonFlag(command, &arguments->json);
  command->footer(
      "Example:\n  cairn extract city.gpkg --bbox 49.01,8.40,49.02,8.42 --out center.gpkg");
  command->callback(
      [shell, arguments] { shell->run = [arguments] { return RunExtract(*arguments); }; });
}

}  // namespace cairn
