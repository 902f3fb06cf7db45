// `cairn map`: folders of photos become sessions of a map.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "cli/arguments.h"
#include "cli/height_option.h"
#include "cli/ingest_summary.h"
#include "cli/json_output.h"
#include "cli/map_session.h"
#include "cli/map_summary.h"
#include "cli/options_file.h"
#include "cli/recording_time.h"
#include "cli/session_arguments.h"
#include "cli/shell.h"
#include "core/error.h"
#include "core/parallel_for.h"
#include "core/printable.h"

namespace cairn {
namespace {

struct MapArguments : MapSessionArguments {
  std::vector<std::string> cameras;  // As of ParseCamera.
};

void PrintMapped(const MapSessionResult& result) {
  if (result.is_mapped) {
    PrintMappedPhotos(result);
  }
  if (result.is_in_map) {
    PrintIngestText(result.name, result.session.georegistration, result.report);
  } else {
    fmt::print("session          {}\nnot in the map   {}\n", Excerpt(result.name), result.problem);
  }
}

void PrintResults(const std::vector<MapSessionResult>& results, bool as_json) {
  if (as_json) {
    cairn::PrintJson(MapSessionsJson(results));  // Not the one of another verb in this namespace.
    return;
  }
  for (const MapSessionResult& result : results) {
    PrintMapped(result);
    fmt::print("{}", &result == &results.back() ? "" : "\n");
  }
}

// Programs have to see that not all became part of the map.
void RequireAllInMap(const std::vector<MapSessionResult>& results) {
  std::vector<std::string> missing;
  ErrorCode code = ErrorCode::kBadInput;
  for (const MapSessionResult& result : results) {
    if (!result.is_in_map) {
      missing.push_back(Excerpt(result.name));
      code = result.mapped.num_mapped > 0 ? ErrorCode::kConflict : code;
    }
  }
  if (!missing.empty()) {
    throw Error(code, fmt::format("{} of {} sessions are not in the map: {}; the summary says why. "
                                  "The map has the others",
                                  missing.size(), results.size(), fmt::join(missing, ", ")));
  }
}

ExitCode RunMap(MapArguments arguments, ProgressMode progress_mode) {
  WarnOfFuture(arguments.session.options.ingest.recorded_at);
  for (const std::string& camera : arguments.cameras) {
    arguments.input.cameras.push_back(ParseCamera("--camera", camera));
  }
  std::vector<MapSessionResult> results;
  {
    Progress progress(progress_mode);
    results = MakeMapSessions(arguments, [&](const char* phase, int64_t done, int64_t total) {
      progress.Update(phase, done, total);
    });
  }
  PrintResults(results, arguments.session.json);
  RequireAllInMap(results);
  return ExitCode::kOk;
}

void AddInputOptions(CLI::App* command, MapArguments* arguments) {
  MapPhotosInput& input = arguments->input;
  command
      ->add_option("--gps", input.positions_path,
                   "CSV of camera positions: image,lat_deg,lon_deg,h_m[,accuracy_m]; see --height. "
                   "Default: the EXIF of the photos")
      ->type_name("CSV");
  command
      ->add_option("--gps-accuracy", input.gps_accuracy_m,
                   "Accuracy of EXIF positions that state none: 68 % radius, meters")
      ->check(PositiveNumber())
      ->type_name("M")
      ->capture_default_str();
  AddHeightOption(command, &input.height,
                  "Reference of the heights: the WGS84 ellipsoid or mean sea level (EGM96). "
                  "Default: msl, as in EXIF; ellipsoid for --gps");
  command
      ->add_option("--camera-height", input.camera_height_m,
                   "Height of the cameras whose positions have none, with the reference of "
                   "--height. Default: that of the others")
      ->check(NumberWithin(-12'000.0, 12'000.0))
      ->type_name("M");
  command
      ->add_option("--camera", arguments->cameras,
                   "Intrinsics of a calibrated camera, for photos of its size and their smaller "
                   "copies: MODEL,width,height,params with COLMAP's models. May be repeated. "
                   "Default: the focal length of the EXIF, or a guess; both are adjusted")
      ->type_name("CAMERA");
  command
      ->add_option("--work", input.work_dir,
                   "Folder that keeps the results of stages, with which a killed run goes on")
      ->type_name("DIR");
}

void AddSessionOptions(CLI::App* command, MapArguments* arguments) {
  IngestOptions& options = arguments->session.options.ingest;
  AddUpOption(command, &arguments->session.options);
  command
      ->add_option("--session", options.session_name,
                   "Name of the session, which replaces an existing session of that name; several "
                   "folders are one session then. Default: each folder is a session of its name, "
                   "which replaces only a session of the same photos")
      ->type_name("NAME");
  AddRecordedOption(command,
                    "When the photos were taken, e.g. 2026-01-31 or 2026-01-31T12:00:00Z. Default: "
                    "as the map has "
                    "it if it has these photos under this name, else now",
                    &options.recorded_at);
  command
      ->add_option(
          "--archive", arguments->archive_path,
          "Folder that keeps the session as it is ingested, for cairn rebuild. Made if there "
          "is none. One folder for each map")
      ->type_name("DIR");
  CLI::Option* apart = command->add_flag(
      "--apart", arguments->session.apart,
      "Do not compare the session with the map, and keep its landmarks beside those of the map");
  command->add_flag("--join")
      ->description(
          "The map stays, and the session is fitted to it. This is the default, so the flag "
          "changes nothing; the opposite is --apart")
      ->excludes(apart);
  AddForceFlag(command, &arguments->session.force);
  AddWaitOption(command, &arguments->session.wait_s);
  command
      ->add_option("--threads", options.num_threads,
                   "Threads; the result does not depend on them. Default: all cores")
      ->check(CLI::Range(1, 1024));
  AddJsonFlag(command, &arguments->session.json);
}

}  // namespace

void AddMapCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("map", "Make a map from photos, or add photos to one");
  auto arguments = std::make_shared<MapArguments>();
  arguments->session.options.ingest.num_threads = NumCores();
  command
      ->add_option("MAP", arguments->session.map_path,
                   "Map: a file or a postgresql:// URL. Made if there is none")
      ->required();
  command->add_option("PHOTOS", arguments->input.paths, "Folders of photos")->required();
  AddOptionsFile(command, &arguments->session.options);
  AddInputOptions(command, arguments.get());
  AddSessionOptions(command, arguments.get());
  command->footer(
      "Examples:\n"
      "  cairn map town.gpkg photos/ --session monday\n"
      "  cairn map town.gpkg tuesday/ wednesday/");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunMap(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
