// `cairn export`: writes a map in the formats of other programs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>

#include "cli/choice_option.h"
#include "cli/exports/export_geojson.h"
#include "cli/exports/export_points.h"
#include "cli/json_output.h"
#include "cli/shell.h"
#include "cli/world_frame_option.h"
#include "core/error.h"
#include "core/printable.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct ExportArguments {
  std::string map_path;
  std::string colmap_dir;
  bool as_text = false;
  std::string ply_path;
  PointColor color = PointColor::kSession;
  std::string keyframes_path;
  std::string coverage_path;
  std::string session;
  WorldFrameArguments frame;
  bool json = false;
};

std::optional<SessionId> SessionToExport(const ExportArguments& arguments, const MapSnapshot& map) {
  if (arguments.session.empty()) {
    return std::nullopt;
  }
  const std::optional<SessionRecord> session = map.FindSession(arguments.session);
  if (!session) {
    throw Error(ErrorCode::kNotFound,
                fmt::format("the map has no session '{}'; 'cairn info' lists them",
                            Excerpt(arguments.session)));
  }
  return session->id;
}

ExportedPoints ExportToPoints(const ExportArguments& arguments,
                              const std::optional<SessionId>& session, const WorldFrame& frame,
                              ProgressMode progress_mode, const MapSnapshot& map) {
  if (!arguments.colmap_dir.empty()) {
    std::error_code failure;
    std::filesystem::create_directories(arguments.colmap_dir, failure);
    if (failure) {
      throw Error(ErrorCode::kIo,
                  fmt::format("{}: {}", Printable(arguments.colmap_dir), failure.message()));
    }
  }
  Progress progress(progress_mode);
  ExportPointsOptions options;
  options.colmap_dir = arguments.colmap_dir;
  options.colmap_format = arguments.as_text ? ColmapModelFormat::kText : ColmapModelFormat::kBinary;
  options.ply_path = arguments.ply_path;
  options.color = arguments.color;
  options.session = session;
  options.world_from_ecef = frame.ecef_from_world.Inverse();
  options.progress = [&](int64_t done, int64_t total) { progress.Update("tiles", done, total); };
  return ExportPoints(map, options);
}

nlohmann::ordered_json PointsJson(const ExportedPoints& points, const WorldFrame& frame) {
  nlohmann::ordered_json json = {
      {"cameras", points.num_cameras},     {"images", points.num_images},
      {"points", points.num_points},       {"observations", points.num_observations},
      {"unseenPoints", points.num_unseen}, {"frame", {{"name", frame.name}}}};
  if (frame.origin) {
    json["frame"]["origin"] = {{"lat", frame.origin->lat_deg()},
                               {"lon", frame.origin->lon_deg()},
                               {"h", frame.origin->h_m}};
  }
  return json;
}

void PrintPointsText(const ExportArguments& arguments, const ExportedPoints& points,
                     const WorldFrame& frame) {
  if (!arguments.colmap_dir.empty()) {
    fmt::print("{}: {} cameras, {} images, {} points, {} observations\n",
               Printable(arguments.colmap_dir), points.num_cameras, points.num_images,
               points.num_points - points.num_unseen, points.num_observations);
  }
  if (!arguments.ply_path.empty()) {
    fmt::print("{}: {} points\n", Printable(arguments.ply_path), points.num_points);
  }
  fmt::print("frame: {}\n", frame.Text());
}

ExitCode RunExport(const ExportArguments& arguments, ProgressMode progress_mode) {
  const bool has_points = !arguments.colmap_dir.empty() || !arguments.ply_path.empty();
  if (!has_points && arguments.keyframes_path.empty() && arguments.coverage_path.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                "say what to write: --colmap, --ply, --keyframes or --coverage");
  }
  const MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadOnly);
  const MapSnapshot map = store.Snapshot();
  const std::optional<SessionId> session = SessionToExport(arguments, map);
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  if (has_points) {
    const WorldFrame frame = WorldFrameOf(arguments.frame, FrameChoice::kEnu, &map);
    const ExportedPoints points = ExportToPoints(arguments, session, frame, progress_mode, map);
    json = PointsJson(points, frame);
    if (!arguments.json) {
      PrintPointsText(arguments, points, frame);
    }
  }
  const auto note = [&](const char* member, const std::string& path, int64_t count,
                        const char* what) {
    json[member] = count;
    if (!arguments.json) {
      fmt::print("{}: {} {}\n", Printable(path), count, what);
    }
  };
  if (!arguments.keyframes_path.empty()) {
    note("keyframes", arguments.keyframes_path,
         ExportKeyframesGeoJson(map, session, arguments.keyframes_path), "keyframes");
  }
  if (!arguments.coverage_path.empty()) {
    note("tiles", arguments.coverage_path, ExportCoverageGeoJson(map, arguments.coverage_path),
         "tiles");
  }
  if (arguments.json) {
    PrintJson(json);
  }
  return ExitCode::kOk;
}

void AddPointOptions(CLI::App* command, ExportArguments* arguments) {
  static constexpr EnumName<PointColor> kColors[] = {{"session", PointColor::kSession},
                                                     {"height", PointColor::kHeight},
                                                     {"uncertainty", PointColor::kUncertainty}};
  auto* const colmap = command
                           ->add_option("--colmap", arguments->colmap_dir,
                                        "Folder for a COLMAP model: cameras, images, points3D")
                           ->type_name("DIR");
  command->add_flag("--text", arguments->as_text, "Write the model as text, not binary")
      ->needs(colmap);
  command->add_option("--ply", arguments->ply_path, "PLY file for the landmarks")
      ->type_name("FILE");
  AddChoiceOption(command, "--color", NamedChoice(&arguments->color, kColors),
                  "Color of the points: by the oldest session that saw them, by the height over "
                  "the cameras, or by the standard deviation of their position");
  AddWorldFrameOptions(command, "Frame of the model and of the points", FrameChoice::kEnu,
                       &arguments->frame);
}

}  // namespace

void AddExportCommand(CLI::App* app, Shell* shell) {
  CLI::App* command =
      app->add_subcommand("export", "Write a map as a COLMAP model, PLY or GeoJSON");
  auto arguments = std::make_shared<ExportArguments>();
  command->add_option("MAP", arguments->map_path, "Map: a file or a postgresql:// URL")->required();
  AddPointOptions(command, arguments.get());
  command
      ->add_option("--keyframes", arguments->keyframes_path,
                   "GeoJSON file for the places of the mapping photos")
      ->type_name("FILE");
  command->add_option("--coverage", arguments->coverage_path, "GeoJSON file for the tiles")
      ->type_name("FILE");
  command
      ->add_option("--session", arguments->session,
                   "Only the photos of this session, and the landmarks that it saw")
      ->type_name("NAME");
  AddJsonFlag(command, &arguments->json);
  command->footer(
      "Example:\n  cairn export city.gpkg --colmap model/ --ply city.ply --color height");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunExport(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
