// cairn.init, cairn.ingest and cairn.map: what the verbs of these names do.
#include "python/building.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/ingest_placed.h"
#include "cli/ingest_summary.h"
#include "cli/map_session.h"
#include "cli/map_summary.h"
#include "cli/session_arguments.h"
#include "cli/session_replacement.h"
#include "core/parallel_for.h"
#include "python/arguments.h"
#include "python/camera.h"
#include "python/docs.h"
#include "python/interruptible.h"
#include "storage/map/map_store.h"

namespace cairn::python {
namespace {

// What a session became, or the sessions of one call.
struct Summary {
  std::string session;
  std::optional<MapVersion> map_version;  // Of a session that is in the map.
  bool is_unchanged = false;
  std::string problem;  // Of one that is not.
  nlohmann::ordered_json details;
  std::vector<Summary> sessions;  // Empty: only this one.
};

void Init(const py::object& path_argument) {
  const std::string path = PathOf("path", path_argument);
  const py::gil_scoped_release release;
  MapStore::Create(path);
}

std::optional<HeightReference> HeightOf(py::handle value) {
  if (value.is_none()) {
    return std::nullopt;
  }
  const auto reference = HeightReferenceFromName(TextOf("height", value));
  if (!reference) {
    RefuseArgument("height", "must be 'ellipsoid' or 'msl'");
  }
  return reference;
}

// The keywords that ingest and map share.
void ReadSessionKeywords(const py::kwargs& keywords, SessionArguments* arguments) {
  arguments->options = OptionsOf(keywords["options"]);
  IngestOptions& options = arguments->options.ingest;
  options.session_name =
      keywords["session"].is_none() ? "" : TextOf("session", keywords["session"]);
  options.recorded_at =
      keywords["recorded_at"].is_none() ? "" : TextOf("recorded_at", keywords["recorded_at"]);
  options.num_threads = ThreadsOf("threads", keywords["threads"]);
  arguments->apart = FlagOf("apart", keywords["apart"]);
  arguments->force = FlagOf("force", keywords["force"]);
  arguments->wait_s = NumberOf("wait_s", keywords["wait_s"], 0.0, 86400.0);
}

std::optional<double> CameraHeightOf(py::handle value) {
  if (value.is_none()) {
    return std::nullopt;
  }
  return NumberOf("camera_height_m", value, -12'000.0, 12'000.0);
}

// `frame` and `origin`: the model stands on Earth already.
WorldFrameArguments ModelFrameOf(py::handle frame, py::handle origin) {
  WorldFrameArguments arguments;
  if (!frame.is_none()) {
    const std::string word = TextOf("frame", frame);
    if (word != "ecef" && word != "enu") {
      RefuseArgument("frame", "must be 'ecef' or 'enu'");
    }
    arguments.frame = word == "ecef" ? FrameChoice::kEcef : FrameChoice::kEnu;
  }
  if (arguments.frame == FrameChoice::kEnu && origin.is_none()) {
    RefuseArgument("origin", "is needed for frame='enu': the place of the model's origin");
  }
  if (!origin.is_none()) {
    if (arguments.frame != FrameChoice::kEnu) {
      RefuseArgument("origin", "is for frame='enu'");
    }
    const Geodetic place = PositionOf("origin", origin);
    if (py::len(origin) != 3) {
      RefuseArgument("origin",
                     "must be (latitude, longitude, height), degrees and meters above the "
                     "ellipsoid");
    }
    arguments.origin = fmt::format("{},{},{}", place.lat_deg(), place.lon_deg(), place.h_m);
  }
  return arguments;
}

// The sources of positions exclude each other.
void RequireOneSource(const ReconstructionArguments& reconstruction) {
  const std::pair<const char*, bool> sources[] = {
      {"gps", reconstruction.use_gps},
      {"georef", !reconstruction.georef_path.empty()},
      {"control", !reconstruction.control_path.empty()},
      {"frame", reconstruction.frame.frame.has_value()}};
  const char* given = nullptr;
  for (const auto& [name, is_given] : sources) {
    if (is_given && given != nullptr) {
      RefuseArgument(
          name, fmt::format("says where the model stands, as {} does; give one of them", given));
    }
    given = is_given ? name : given;
  }
  if (given == nullptr) {
    RefuseArgument("georef",
                   "the position of the model on Earth is unknown; give georef, gps=True, control "
                   "or frame");
  }
}

SessionArguments IngestArgumentsOf(const py::object& path, const py::kwargs& keywords) {
  SessionArguments arguments;
  arguments.map_path = PathOf("path", path);
  ReadSessionKeywords(keywords, &arguments);
  ReconstructionArguments& reconstruction = arguments.reconstruction;
  reconstruction.model_dir = PathOf("model", keywords["model"]);
  reconstruction.database_path = PathOf("database", keywords["database"]);
  reconstruction.use_gps = FlagOf("gps", keywords["gps"]);
  reconstruction.georef_path = PathOrEmpty("georef", keywords["georef"]);
  reconstruction.gps_accuracy_m = PositiveOf("gps_accuracy_m", keywords["gps_accuracy_m"]);
  reconstruction.height = HeightOf(keywords["height"]);
  reconstruction.camera_height_m = CameraHeightOf(keywords["camera_height_m"]);
  reconstruction.photo_dir = PathOrEmpty("photos", keywords["photos"]);
  arguments.image_list_path = PathOrEmpty("images", keywords["images"]);
  reconstruction.control_path = PathOrEmpty("control", keywords["control"]);
  reconstruction.frame = ModelFrameOf(keywords["frame"], keywords["origin"]);
  RequireOneSource(reconstruction);
  return arguments;
}

Summary SummaryOf(const PlacedReconstruction& session, const IngestReport& report) {
  const std::string& name = session.options.session_name;
  return {.session = name,
          .map_version = report.map_version,
          .is_unchanged = report.is_unchanged,
          .problem = "",
          .details = IngestJson(name, session.georegistration, report),
          .sessions = {}};
}

Summary Ingest(const py::object& path, const py::kwargs& keywords) {
  const SessionArguments arguments = IngestArgumentsOf(path, keywords);
  const std::string archive_path = PathOrEmpty("archive", keywords["archive"]);
  Summary summary;
  RunInterruptibly(keywords["progress"], [&](const WorkProgress& report) {
    MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadWrite);
    const std::unique_ptr<SessionArchive> archive =
        OpenSessionArchive(archive_path, SessionNameOf(arguments), store);
    const PlacedReconstruction session = ReadSession(arguments);
    CheckReplacement(store.Snapshot(), session, HasSessionName(arguments));
    summary =
        SummaryOf(session, IngestPlaced(session, arguments.options, archive.get(), report, &store));
  });
  return summary;
}

void AddPhotos(const py::object& photos, std::vector<std::string>* paths) {
  if (IsPath(photos)) {
    paths->push_back(PathOf("photos", photos));
    return;
  }
  if (!py::isinstance<py::iterable>(photos)) {
    RefuseArgument("photos", "must be a folder, or a sequence of folders and files");
  }
  for (const py::handle photo : photos) {
    paths->push_back(PathOf("photos", photo));
  }
  if (paths->empty()) {
    RefuseArgument("photos", "is empty");
  }
}

MapSessionArguments MapArgumentsOf(const py::object& path, const py::object& photos,
                                   const py::kwargs& keywords) {
  MapSessionArguments arguments;
  arguments.session.map_path = PathOf("path", path);
  ReadSessionKeywords(keywords, &arguments.session);
  MapPhotosInput& input = arguments.input;
  AddPhotos(photos, &input.paths);
  input.positions_path = PathOrEmpty("gps", keywords["gps"]);
  input.gps_accuracy_m = PositiveOf("gps_accuracy_m", keywords["gps_accuracy_m"]);
  input.height = HeightOf(keywords["height"]);
  input.camera_height_m = CameraHeightOf(keywords["camera_height_m"]);
  input.work_dir = PathOrEmpty("work", keywords["work"]);
  if (!py::isinstance<py::iterable>(keywords["cameras"])) {
    RefuseArgument("cameras", "must be a sequence of cairn.Camera");
  }
  for (const py::handle camera : keywords["cameras"]) {
    const std::optional<StatedCamera> stated = CameraOf("cameras", camera);
    if (!stated || stated->focal) {
      RefuseArgument("cameras", "must be calibrated, without a focal_sigma");
    }
    input.cameras.push_back(stated->camera);
  }
  arguments.archive_path = PathOrEmpty("archive", keywords["archive"]);
  return arguments;
}

Summary SummaryOf(const MapSessionResult& result) {
  Summary summary;
  summary.session = result.name;
  summary.problem = result.problem;
  summary.details = MapSessionJson(result);
  if (result.is_in_map) {
    summary.map_version = result.report.map_version;
    summary.is_unchanged = result.report.is_unchanged;
  }
  return summary;
}

// Of several, that of the session which the map got last, with all of them.
Summary SummaryOf(const std::vector<MapSessionResult>& results) {
  if (results.size() == 1) {
    return SummaryOf(results.front());
  }
  Summary last;
  bool is_unchanged = true;
  std::vector<Summary> sessions;
  for (const MapSessionResult& result : results) {
    sessions.push_back(SummaryOf(result));
    if (result.is_in_map) {
      is_unchanged = is_unchanged && result.report.is_unchanged;
      if (sessions.back().map_version > last.map_version) {
        last = sessions.back();
      }
    }
  }
  last.is_unchanged = is_unchanged;
  last.details = MapSessionsJson(results);
  last.sessions = std::move(sessions);
  return last;
}

Summary Map(const py::object& path, const py::object& photos, const py::kwargs& keywords) {
  const MapSessionArguments arguments = MapArgumentsOf(path, photos, keywords);
  Summary summary;
  RunInterruptibly(keywords["progress"], [&](const WorkProgress& report) {
    summary = SummaryOf(MakeMapSessions(arguments, report));
  });
  return summary;
}

// Every session of the call, also if it is one.
py::list SessionsOf(const Summary& summary) {
  py::list sessions;
  for (const Summary& session : summary.sessions) {
    sessions.append(session);
  }
  if (summary.sessions.empty()) {
    sessions.append(summary);
  }
  return sessions;
}

py::object DetailsOf(const Summary& summary) {
  return py::module_::import("json").attr("loads")(
      summary.details.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace

void BindBuilding(py::module_* module) {
  using py::arg;
  py::class_<Summary>(*module, "Summary", docs::kSummary)
      .def_property_readonly(
          "session", [](const Summary& summary) { return TextOut(summary.session); },
          "Name of the session; of several, that of the one which the map got last.")
      .def_property_readonly(
          "map_version",
          [](const Summary& summary) {
            return summary.map_version ? std::optional(Value(*summary.map_version)) : std::nullopt;
          },
          "The version that has the session, or all of several; None if it is not in the map.")
      .def_readonly("unchanged", &Summary::is_unchanged,
                    "Whether the map had exactly this session, or these sessions, already.")
      .def_property_readonly(
          "problem",
          [](const Summary& summary) -> std::optional<py::str> {
            return summary.problem.empty() ? std::nullopt : std::optional(TextOut(summary.problem));
          },
          "Why the session is not in the map; None if it is.")
      .def_property_readonly("sessions", &SessionsOf, "A Summary for each session of the call.")
      .def_property_readonly("details", &DetailsOf, "All that the verb prints with --json.");
  module->def("init", &Init, arg("path"), docs::kInit);
  module->def("_ingest", &Ingest, arg("path"));
  module->def("_map", &Map, arg("path"), arg("photos"));
}

}  // namespace cairn::python
