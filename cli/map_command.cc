// `cairn map`: folders of photos become a session of a map.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/arguments.h"
#include "cli/choice_option.h"
#include "cli/height_option.h"
#include "cli/ingest_placed.h"
#include "cli/ingest_summary.h"
#include "cli/map_summary.h"
#include "cli/options_file.h"
#include "cli/session_archive.h"
#include "cli/session_arguments.h"
#include "cli/session_replacement.h"
#include "cli/shell.h"
#include "core/error.h"
#include "core/parallel_for.h"
#include "core/printable.h"
#include "core/replace_file.h"
#include "ingest/ingest_session.h"
#include "ingest/maps/archive_folder.h"
#include "mapping/session/map_photos.h"
#include "mapping/session/report_svg.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct MapArguments {
  SessionArguments session;  // Without a reconstruction.
  MapPhotosInput input;
  std::vector<std::string> cameras;  // As of ParseCamera.
  std::string archive_path;          // Empty: no archive.
};

// Nothing if there is no map yet.
std::optional<MapStore> OpenMap(const std::string& path) {
  try {
    return MapStore::Open(path, OpenMode::kReadWrite);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotFound) {
      throw;
    }
    return std::nullopt;
  }
}

// A name that replaces nothing by accident is that of the folder.
std::string SessionName(const MapArguments& arguments) {
  const IngestOptions& options = arguments.session.options.ingest;
  if (!options.session_name.empty()) {
    return options.session_name;
  }
  const std::filesystem::path path =
      std::filesystem::absolute(arguments.input.paths.front()).lexically_normal();
  const std::string name = (path.has_filename() ? path : path.parent_path()).filename().string();
  return name.empty() ? "session" : name;
}

// Whether the map has sessions, other than one that is replaced, that the new one may join.
bool HasOthersToJoin(const std::optional<MapStore>& map, const MapArguments& arguments) {
  if (!map || arguments.session.apart) {
    return false;
  }
  const std::vector<SessionRecord> sessions = map->Snapshot().Sessions();
  const std::string name = SessionName(arguments);
  return std::any_of(sessions.begin(), sessions.end(),
                     [&](const SessionRecord& session) { return session.name != name; });
}

// Moves the model out of `mapped`.
PlacedReconstruction SessionOf(const MapArguments& arguments, MappedPhotos* mapped) {
  PlacedReconstruction session;
  session.reconstruction = std::move(mapped->model);
  session.georegistration = mapped->georegistration;
  session.georegistration.ecef_from_world = mapped->ecef_from_world;
  session.options = arguments.session.options.ingest;
  IngestOptions& options = session.options;
  options.session_name = SessionName(arguments);
  options.source = arguments.input.paths.front();
  options.joining = arguments.session.apart ? SessionJoining::kApart : SessionJoining::kJoin;
  options.georef_median_residual_m = session.georegistration.median_residual_m;
  if (options.agreement.position_accuracy_m == 0.0) {
    options.agreement.position_accuracy_m = session.georegistration.stated_accuracy_m;
  }
  if (arguments.session.force) {
    options.gate.max_lost_share = 1.0;
  }
  if (options.earth_accuracy_m == 0.0) {
    options.earth_accuracy_m = session.georegistration.accuracy.position_m;
    options.earth_accuracy_rad = session.georegistration.accuracy.rotation_rad;
  }
  options.patience = PatienceOf(arguments.session.wait_s);
  return session;
}

void PrintMapped(const MapArguments& arguments, const MappedPhotos& mapped,
                 const PlacedReconstruction& session, const IngestReport& report) {
  const std::string& name = session.options.session_name;
  if (arguments.session.json) {
    const nlohmann::ordered_json summary = {
        {"photos", MappedPhotosJson(mapped)},
        {"ingest", IngestJson(name, session.georegistration, report)}};
    cairn::PrintJson(summary);  // Not the one of another verb in this namespace.
    return;
  }
  PrintMappedPhotos(mapped);
  PrintIngestText(name, session.georegistration, report);
}

// Publishes the session in the map, which is made if there is none yet: then there is all of it or
// nothing.
IngestReport Publish(const MapArguments& arguments, const PlacedReconstruction& session,
                     std::optional<MapStore>* map, Progress* progress) {
  const std::string& path = arguments.session.map_path;
  IngestReport report;
  const auto publish = [&](MapStore* store) {
    CheckReplacement(store->Snapshot(), session, HasSessionName(arguments.session));
    const std::unique_ptr<SessionArchive> archive =
        OpenSessionArchive(arguments.archive_path, session.options.session_name, *store);
    report = IngestPlaced(session, arguments.session.options, archive.get(), progress, store);
  };
  if (*map) {
    publish(&**map);
  } else {
    MapStore::CreateFilled(path, publish);
  }
  return report;
}

// Throws Error(kIo) unless the map, a file that does not exist, can be made.
void RequireFolderOf(const std::string& map_path) {
  if (map_path.find("://") != std::string::npos) {
    return;  // A database.
  }
  std::string folder = std::filesystem::path(map_path).parent_path().string();
  folder = folder.empty() ? "." : folder;
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    throw Error(ErrorCode::kIo,
                fmt::format("{}: the map cannot be made in {}: {}", Printable(map_path),
                            Printable(folder), std::strerror(errno)));
  }
}

// Finds before the long work what would refuse its result.
void CheckEarly(const MapArguments& arguments, bool has_map) {
  IngestOptions options = arguments.session.options.ingest;
  options.session_name = SessionName(arguments);
  options.Validate();
  if (!has_map) {
    RequireFolderOf(arguments.session.map_path);
  }
  if (!arguments.archive_path.empty()) {
    const ArchiveFolder archive(arguments.archive_path, ArchiveFolder::Use::kIngest);
  }
}

// Before the publication, so that a session that is refused has its picture, too.
void WriteReport(const std::string& work_dir, const MappedPhotos& mapped) {
  if (!work_dir.empty()) {
    const std::string svg = ReportSvg(mapped);
    ReplaceFile(work_dir + "/report.svg",
                {reinterpret_cast<const uint8_t*>(svg.data()), svg.size()});
  }
}

ExitCode RunMap(MapArguments arguments, ProgressMode progress_mode) {
  for (const std::string& camera : arguments.cameras) {
    arguments.input.cameras.push_back(ParseCamera("--camera", camera));
  }
  const CairnOptions& options = arguments.session.options;
  arguments.input.num_threads = options.ingest.num_threads;
  // Before the long work, so that a map that cannot be written fails at once.
  std::optional<MapStore> map = OpenMap(arguments.session.map_path);
  CheckEarly(arguments, map.has_value());
  arguments.input.one_segment = HasOthersToJoin(map, arguments);
  MappedPhotos mapped;
  PlacedReconstruction session;
  IngestReport report;
  {
    Progress progress(progress_mode);
    mapped = MapPhotos(arguments.input, options.mapping, options.georegister,
                       [&](const char* phase, int64_t done, int64_t total) {
                         progress.Update(phase, done, total);
                       });
    WriteReport(arguments.input.work_dir, mapped);
    session = SessionOf(arguments, &mapped);
    report = Publish(arguments, session, &map, &progress);
  }
  PrintMapped(arguments, mapped, session, report);
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
                   "Name of the session. Replaces an existing session of that name. Default: that "
                   "of the folder, which replaces only a session of the same photos")
      ->type_name("NAME");
  command
      ->add_option("--recorded", options.recorded_at,
                   "When the photos were taken, e.g. 2026-01-31T12:00:00Z. Default: as the map has "
                   "it if it has these photos under this name, else now")
      ->type_name("UTC");
  command
      ->add_option("--archive", arguments->archive_path,
                   "Folder that keeps the session as it is ingested, for cairn rebuild. One folder "
                   "for each map")
      ->type_name("DIR");
  command->add_flag(
      "--apart", arguments->session.apart,
      "Do not compare the session with the map, and keep its landmarks beside those of the map");
  AddForceFlag(command, &arguments->session.force);
  AddWaitOption(command, &arguments->session.wait_s);
  command
      ->add_option("--threads", options.num_threads,
                   "Threads; the result does not depend on them. Default: all cores")
      ->check(CLI::Range(1, 1024));
  command->add_flag("--json", arguments->session.json, "Print the summary as JSON");
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
  command->footer("Example:\n  cairn map town.gpkg photos/ --session monday");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunMap(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
