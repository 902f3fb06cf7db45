#include "cli/map_session.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "cli/ingest_placed.h"
#include "cli/make_descriptor_file.h"
#include "cli/map_report.h"
#include "cli/publish_parts.h"
#include "cli/session_archive.h"
#include "cli/session_replacement.h"
#include "core/error.h"
#include "core/geodesy.h"
#include "core/printable.h"
#include "core/replace_file.h"
#include "ingest/maps/archive_folder.h"
#include "ingest/place/position_checks.h"
#include "mapping/session/stage_clock.h"
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

std::string FolderName(const std::string& folder) {
  const std::filesystem::path path = std::filesystem::absolute(folder).lexically_normal();
  const std::string name = (path.has_filename() ? path : path.parent_path()).filename().string();
  return name.empty() ? "session" : name;
}

// A name that replaces nothing by accident is that of the folder; of several, the first by
// alphabet, so that their order in the command does not matter.
std::string SessionName(const MapSessionArguments& arguments) {
  const IngestOptions& options = arguments.session.options.ingest;
  const std::vector<std::string>& paths = arguments.input.paths;
  return options.session_name.empty() ? FolderName(*std::min_element(paths.begin(), paths.end()))
                                      : options.session_name;
}

// One session of the command.
struct SessionInput {
  std::string name;
  MapPhotosInput photos;
};

std::vector<SessionInput> InputsOfFolders(const MapSessionArguments& arguments) {
  std::vector<SessionInput> inputs;
  for (const std::string& path : arguments.input.paths) {
    SessionInput input = {FolderName(path), arguments.input};
    if (std::any_of(inputs.begin(), inputs.end(),
                    [&](const SessionInput& other) { return other.name == input.name; })) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("two folders have the name {}, and each would be a session of its "
                              "name; rename one, or make all one session with --session",
                              Printable(input.name)));
    }
    input.photos.paths = {path};
    input.photos.table_paths = arguments.input.paths;
    if (!input.photos.work_dir.empty()) {
      input.photos.work_dir += "/" + input.name;
    }
    inputs.push_back(std::move(input));
  }
  return inputs;
}

// Each folder if there are several, and no name was given.
std::vector<SessionInput> SessionInputs(const MapSessionArguments& arguments) {
  const std::vector<std::string>& paths = arguments.input.paths;
  std::error_code ignored;
  const bool are_folders = std::all_of(paths.begin(), paths.end(), [&](const std::string& path) {
    return std::filesystem::is_directory(path, ignored);
  });
  if (paths.size() > 1 && are_folders && !HasSessionName(arguments.session)) {
    return InputsOfFolders(arguments);
  }
  return {{SessionName(arguments), arguments.input}};
}

// Whether the map has sessions, other than one that is replaced, that a new one may join.
bool HasOthersToJoin(const MapStore& map, const MapSessionArguments& arguments,
                     const std::string& name) {
  if (arguments.session.apart) {
    return false;
  }
  const std::vector<SessionRecord> sessions = map.Snapshot().Sessions();
  return std::any_of(sessions.begin(), sessions.end(),
                     [&](const SessionRecord& session) { return session.name != name; });
}

// Moves the model out of `mapped`.
PlacedReconstruction SessionOf(const MapSessionArguments& arguments, const SessionInput& input,
                               MappedPhotos* mapped) {
  PlacedReconstruction session;
  session.reconstruction = std::move(mapped->model);
  session.georegistration = mapped->georegistration;
  session.georegistration.ecef_from_world = mapped->ecef_from_world;
  session.options = arguments.session.options.ingest;
  IngestOptions& options = session.options;
  options.session_name = input.name;
  options.source = input.photos.paths.front();
  options.joining = arguments.session.apart ? SessionJoining::kApart : SessionJoining::kJoin;
  if (!arguments.session.apart) {
    options.agreement.unanchored = Unanchored::kRefuse;
  }
  options.fitting = SessionFitting::kAdjust;
  // Positions that place nothing are as good as they state.
  options.georef_median_residual_m = mapped->num_mapped > 0
                                         ? session.georegistration.median_residual_m
                                         : session.georegistration.stated_accuracy_m;
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

// The progress of one of several sessions: its name stands before the phase.
IngestProgress ForSession(const IngestProgress& progress, const std::string& name,
                          size_t num_sessions) {
  if (num_sessions == 1 || !progress) {
    return progress;
  }
  return [&progress, name](const char* phase, int64_t done, int64_t total) {
    progress((Excerpt(name) + " " + phase).c_str(), done, total);
  };
}

// Names the sessions that the map has from a command that fails.
[[noreturn]] void ThrowWithWhatStands(const Error& error,
                                      const std::vector<MapSessionResult>& sessions) {
  std::string names;
  for (const MapSessionResult& session : sessions) {
    if (session.is_in_map) {
      names += (names.empty() ? "" : ", ") + Excerpt(session.name);
    }
  }
  throw Error(error.code(),
              names.empty()
                  ? error.what()
                  : fmt::format("{}. The map has these sessions already: {}", error.what(), names));
}

// Makes a map, or leaves nothing: neither the map nor the files in `archived`.
void CreateWithArchive(const std::string& path, const std::function<void(MapStore*)>& fill,
                       const std::vector<std::string>& archived) {
  try {
    MapStore::CreateFilled(path, fill);
  } catch (...) {
    DeleteArchived(archived);
    throw;
  }
}

// Publishes the sessions in the map, which is made if there is none yet: then there is all of it or
// nothing.
void Publish(const MapSessionArguments& arguments, std::optional<MapStore>* map,
             const IngestProgress& progress, std::vector<MapSessionResult>* sessions) {
  std::vector<std::string> archived;
  const auto publish = [&](MapStore* store) {
    const auto publish_placed = [&](const PlacedReconstruction& session) {
      CheckReplacement(store->Snapshot(), session, HasSessionName(arguments.session));
      const std::unique_ptr<SessionArchive> archive =
          OpenSessionArchive(arguments.archive_path, session.options.session_name, *store);
      if (archive != nullptr) {
        archive->ListFilesIn(&archived);
      }
      return IngestPlaced(session, arguments.session.options, archive.get(),
                          ForSession(progress, session.options.session_name, sessions->size()),
                          store);
    };
    const auto publish_one = [&](MapSessionResult* result) {
      StageClock clock("publication", &result->mapped.stages);
      IngestReport report = HasOthersToJoin(*store, arguments, result->name)
                                ? PublishParts(store->Snapshot(), publish_placed, result)
                                : PublishAsPlaced(publish_placed, *result);
      clock.End(/*from_work=*/false);
      return report;
    };
    PublishInTurn(publish_one, store->Snapshot().Sessions().empty(), sessions);
    for (MapSessionResult& result : *sessions) {
      const MapSnapshot snapshot = store->Snapshot();
      if (result.is_in_map && !result.mapped.unplaced.empty() &&
          Value(result.report.map_version) < Value(snapshot.version()) &&
          HasOthersToJoin(*store, arguments, result.name)) {
        StageClock clock("parts left out", &result.mapped.stages);
        PublishLeftOut(snapshot, publish_placed, &result);
        clock.End(/*from_work=*/false);
      }
    }
  };
  if (!*map) {
    CreateWithArchive(arguments.session.map_path, publish, archived);
    return;
  }
  try {
    publish(&**map);
  } catch (const Error& error) {
    ThrowWithWhatStands(error, *sessions);
  }
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
void CheckEarly(const MapSessionArguments& arguments, const std::vector<SessionInput>& inputs,
                bool has_map) {
  for (const SessionInput& input : inputs) {
    IngestOptions options = arguments.session.options.ingest;
    options.session_name = input.name;
    options.Validate();
  }
  if (!has_map) {
    RequireFolderOf(arguments.session.map_path);
  }
  if (!arguments.archive_path.empty()) {
    const ArchiveFolder archive(arguments.archive_path, ArchiveFolder::Use::kIngest);
  }
}

// Before the publication, too, so that a session that is refused has its picture.
void WriteReport(const std::string& work_dir, const std::vector<MapSessionResult>& sessions) {
  if (!work_dir.empty()) {
    const Drawing drawing = DrawMapReport(sessions);
    const std::string svg = drawing.ToSvg();
    ReplaceFile(work_dir + "/report.svg",
                {reinterpret_cast<const uint8_t*>(svg.data()), svg.size()});
    ReplaceFile(work_dir + "/report.png", drawing.ToPng());
  }
}

// Whether the map has sessions, but for one of this name, within some kilometers.
bool HasOthersAbout(const MapSnapshot& map, const std::string& name, const Geodetic& place) {
  constexpr double kAboutM = 2000.0;
  const std::vector<TileRecord> about = map.FindTiles(BoxAround(place, kAboutM));
  if (about.empty() || !map.FindSession(name)) {
    return !about.empty();
  }
  std::set<TileId> of_others;
  for (const SessionRecord& other : map.Sessions()) {
    if (other.name != name) {
      const std::vector<TileId> tiles = map.TilesOfSession(other.id);
      of_others.insert(tiles.begin(), tiles.end());
    }
  }
  return std::any_of(about.begin(), about.end(),
                     [&](const TileRecord& tile) { return of_others.count(tile.tile_id) > 0; });
}

// A session that joins others does not stand where it would be near them with latitude and
// longitude exchanged. Of several sessions, that is the problem of one; of one, an error.
void RequireRightWayRound(const std::optional<MapStore>& map, const MapSessionArguments& arguments,
                          std::vector<MapSessionResult>* sessions) {
  for (MapSessionResult& session : *sessions) {
    if (!map || session.mapped.num_mapped == 0 || !HasOthersToJoin(*map, arguments, session.name)) {
      continue;
    }
    const Geodetic place =
        GeodeticFromEcef(session.session.georegistration.ecef_from_world.translation);
    try {
      RequireNotExchanged({{session.name, place}}, [&](const Geodetic& about) {
        return HasOthersAbout(map->Snapshot(), session.name, about);
      });
    } catch (const Error& error) {
      if (sessions->size() == 1) {
        throw;
      }
      session.problem = error.what();
      session.is_mapped = false;
    }
  }
}

// Maps one folder and places it by its positions. If there will be sessions that it may join, its
// segments may lack a place.
MapSessionResult MapFolder(const MapSessionArguments& arguments, const SessionInput& input,
                           const std::shared_ptr<DescriptorFile>& descriptors, bool may_join,
                           const IngestProgress& progress) {
  const CairnOptions& options = arguments.session.options;
  MapPhotosInput photos = input.photos;
  photos.num_threads = options.ingest.num_threads;
  photos.descriptors = descriptors;
  photos.keeps_unplaced = may_join;
  MapSessionResult result;
  result.name = input.name;
  result.mapped = MapPhotos(photos, options.mapping, options.georegister, progress);
  result.session = SessionOf(arguments, input, &result.mapped);
  result.is_mapped = true;
  return result;
}

// As MapFolder, but what the folder's photos are to blame for is a problem of this session, and so
// is an adjustment that fails.
MapSessionResult TryMapFolder(const MapSessionArguments& arguments, const SessionInput& input,
                              const std::shared_ptr<DescriptorFile>& descriptors,
                              const IngestProgress& progress) {
  try {
    return MapFolder(arguments, input, descriptors, !arguments.session.apart, progress);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kBadInput && error.code() != ErrorCode::kInternal) {
      throw;
    }
    MapSessionResult failed;
    failed.name = input.name;
    failed.problem = error.what();
    return failed;
  }
}

std::vector<MapSessionResult> MakeSessions(const MapSessionArguments& arguments,
                                           const std::vector<SessionInput>& inputs,
                                           const IngestProgress& progress) {
  // Before the long work, so that a map that cannot be written fails at once.
  std::optional<MapStore> map = OpenMapIfThere(arguments.session.map_path);
  CheckEarly(arguments, inputs, map.has_value());
  const std::shared_ptr<DescriptorFile> descriptors = MakeDescriptorFile();
  std::vector<MapSessionResult> sessions;
  if (inputs.size() == 1) {
    const SessionInput& input = inputs.front();
    const bool may_join = map && HasOthersToJoin(*map, arguments, input.name);
    sessions.push_back(MapFolder(arguments, input, descriptors, may_join, progress));
  } else {
    for (const SessionInput& input : inputs) {
      sessions.push_back(TryMapFolder(arguments, input, descriptors,
                                      ForSession(progress, input.name, inputs.size())));
    }
    SortSessions(&sessions);
  }
  WriteReport(arguments.input.work_dir, sessions);
  RequireRightWayRound(map, arguments, &sessions);
  Publish(arguments, &map, progress, &sessions);
  WriteReport(arguments.input.work_dir, sessions);
  return sessions;
}

}  // namespace

MapSessionResult MakeMapSession(MapSessionArguments arguments, const IngestProgress& progress) {
  return std::move(
      MakeSessions(arguments, {{SessionName(arguments), arguments.input}}, progress).front());
}

std::vector<MapSessionResult> MakeMapSessions(const MapSessionArguments& arguments,
                                              const IngestProgress& progress) {
  return MakeSessions(arguments, SessionInputs(arguments), progress);
}

}  // namespace cairn
