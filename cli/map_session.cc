#include "cli/map_session.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "cli/ingest_placed.h"
#include "cli/session_archive.h"
#include "cli/session_replacement.h"
#include "core/error.h"
#include "core/printable.h"
#include "core/replace_file.h"
#include "ingest/maps/archive_folder.h"
#include "mapping/session/report_svg.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

// Nothing if there is no map yet.
std::optional<MapStore> OpenMapIfThere(const std::string& path) {
  try {
    return MapStore::Open(path, OpenMode::kReadWrite);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotFound) {
      throw;
    }
    return std::nullopt;
  }
}

// A name that replaces nothing by accident is that of the folder; of several, the first by
// alphabet, so that their order in the command does not matter.
std::string SessionName(const MapSessionArguments& arguments) {
  const IngestOptions& options = arguments.session.options.ingest;
  if (!options.session_name.empty()) {
    return options.session_name;
  }
  const std::vector<std::string>& paths = arguments.input.paths;
  const std::filesystem::path path =
      std::filesystem::absolute(*std::min_element(paths.begin(), paths.end())).lexically_normal();
  const std::string name = (path.has_filename() ? path : path.parent_path()).filename().string();
  return name.empty() ? "session" : name;
}

// Whether the map has sessions, other than one that is replaced, that the new one may join.
bool HasOthersToJoin(const std::optional<MapStore>& map, const MapSessionArguments& arguments) {
  if (!map || arguments.session.apart) {
    return false;
  }
  const std::vector<SessionRecord> sessions = map->Snapshot().Sessions();
  const std::string name = SessionName(arguments);
  return std::any_of(sessions.begin(), sessions.end(),
                     [&](const SessionRecord& session) { return session.name != name; });
}

// Moves the model out of `mapped`.
PlacedReconstruction SessionOf(const MapSessionArguments& arguments, MappedPhotos* mapped) {
  PlacedReconstruction session;
  session.reconstruction = std::move(mapped->model);
  session.georegistration = mapped->georegistration;
  session.georegistration.ecef_from_world = mapped->ecef_from_world;
  session.options = arguments.session.options.ingest;
  IngestOptions& options = session.options;
  options.session_name = SessionName(arguments);
  options.source = arguments.input.paths.front();
  options.joining = arguments.session.apart ? SessionJoining::kApart : SessionJoining::kJoin;
  if (!arguments.session.apart) {
    options.agreement.unanchored = Unanchored::kRefuse;
  }
  options.fitting = SessionFitting::kAdjust;
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

// Publishes the session in the map, which is made if there is none yet: then there is all of it or
// nothing.
IngestReport Publish(const MapSessionArguments& arguments, const PlacedReconstruction& session,
                     std::optional<MapStore>* map, const IngestProgress& progress) {
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
void CheckEarly(const MapSessionArguments& arguments, bool has_map) {
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

}  // namespace

MapSessionResult MakeMapSession(MapSessionArguments arguments, const IngestProgress& progress) {
  const CairnOptions& options = arguments.session.options;
  arguments.input.num_threads = options.ingest.num_threads;
  // Before the long work, so that a map that cannot be written fails at once.
  std::optional<MapStore> map = OpenMapIfThere(arguments.session.map_path);
  CheckEarly(arguments, map.has_value());
  arguments.input.one_segment = HasOthersToJoin(map, arguments);
  MapSessionResult result;
  result.mapped = MapPhotos(arguments.input, options.mapping, options.georegister, progress);
  WriteReport(arguments.input.work_dir, result.mapped);
  result.session = SessionOf(arguments, &result.mapped);
  result.report = Publish(arguments, result.session, &map, progress);
  return result;
}

}  // namespace cairn
