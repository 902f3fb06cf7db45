#include "cli/session_arguments.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "cli/choice_option.h"
#include "cli/json_output.h"
#include "cli/options_file.h"
#include "cli/recording_time.h"
#include "core/error.h"
#include "ingest/colmap/colmap_reader.h"

namespace cairn {
namespace {

Reconstruction ReadReconstruction(const SessionArguments& arguments) {
  ColmapInput input;
  input.model_dir = arguments.reconstruction.model_dir;
  input.database_path = arguments.reconstruction.database_path;
  if (!arguments.image_list_path.empty()) {
    input.image_names = ReadImageList(arguments.image_list_path);
    if (input.image_names.empty()) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("{}: the list has no image names", arguments.image_list_path));
    }
  }
  return ReadColmap(input);
}

}  // namespace

void AddWaitOption(CLI::App* command, double* wait_s) {
  command->add_option("--wait", *wait_s, "How long to wait while another update of the map runs")
      ->check(CLI::Range(0.0, 86400.0))
      ->type_name("SECONDS")
      ->capture_default_str();
}

std::chrono::milliseconds PatienceOf(double wait_s) {
  return std::chrono::milliseconds(static_cast<int64_t>(1e3 * wait_s));
}

void AddUpOption(CLI::App* command, CairnOptions* options) {
  AddChoiceOption(command, "--up", NamedChoice(&options->georegister.up, kUpSourceNames),
                  "Which way is up: all that is known (auto), the positions alone, the EXIF of the "
                  "photos, the side of the stored pictures that is up (left for a phone held "
                  "upright), or down for photos that look straight down");
}

void AddForceFlag(CLI::App* command, bool* force) {
  command->add_flag("--force", *force,
                    "Publish even if the map no longer localizes keyframes of its own");
}

void AddSessionArguments(CLI::App* command, SessionArguments* arguments) {
  IngestOptions& options = arguments->options.ingest;
  command->add_option("MAP", arguments->map_path, "Map: a file or a postgresql:// URL")->required();
  AddOptionsFile(command, &arguments->options);
  AddReconstructionOptions(command, &arguments->reconstruction);
  command->get_option("--model")->required();
  command->get_option("--database")->required();
  AddUpOption(command, &arguments->options);
  command
      ->add_option("--photos", arguments->reconstruction.photo_dir,
                   "Folder of the model's photos, whose EXIF says how they were held. Default: "
                   "`images` or `photos` near the database or the model, if there")
      ->type_name("DIR");
  command
      ->add_option("--images", arguments->image_list_path,
                   "File with the images of the model to use, one name per line. Default: all")
      ->type_name("FILE");
  command
      ->add_option("--session", options.session_name,
                   "Name of the session. Replaces an existing session of that name. Default: the "
                   "folder of the database, which replaces only a session of the same photos")
      ->type_name("NAME");
  command
      ->add_option("--max-descriptors", options.selection.max_descriptors,
                   "Maximum number of descriptors per tile")
      ->capture_default_str();
  AddChoiceOption(command, "--selection",
                  NamedChoice(&options.selection.kind, kLandmarkSelectionNames),
                  "How the landmarks of a tile are selected: the most observed, or, with coverage, "
                  "by the paper's integer program, which leaves enough to each keyframe");
  AddChoiceOption(command, "--codebook",
                  NamedChoice(&options.codebook.source, kCodebookSourceNames),
                  "Codebook of a new map: shipped with Cairn, trained on this session, or, with "
                  "auto, shipped if the session is small. Maps of one codebook can be merged");
  command
      ->add_option("--code-bytes", options.codebook.num_subspaces,
                   "Bytes per descriptor; used only for the first session of a map")
      ->capture_default_str();
  AddRecordedOption(command,
                    "When the photos were taken, e.g. 2026-01-31 or 2026-01-31T12:00:00Z. Default: "
                    "as the map has "
                    "it if it has these photos under this name, else now. Landmarks that later "
                    "sessions miss fade "
                    "with time",
                    &options.recorded_at);
  command->add_flag(
      "--apart", arguments->apart,
      "Do not compare the session with the map, and keep its landmarks beside those of the map");
  AddForceFlag(command, &arguments->force);
  AddWaitOption(command, &arguments->wait_s);
  AddJsonFlag(command, &arguments->json);
}

bool HasSessionName(const SessionArguments& arguments) {
  return !arguments.options.ingest.session_name.empty();
}

std::string SessionNameOf(const SessionArguments& arguments) {
  if (HasSessionName(arguments)) {
    return arguments.options.ingest.session_name;
  }
  // COLMAP projects keep their database in the top folder, so the name of that folder usually names
  // the project.
  const auto folder = std::filesystem::absolute(arguments.reconstruction.database_path)
                          .parent_path()
                          .filename()
                          .string();
  return folder.empty() ? "session" : folder;
}

void RequirePositions(const SessionArguments& arguments) {
  if (!arguments.reconstruction.HasPositions()) {
    throw Error(
        ErrorCode::kInvalidArgument,
        "the position of the model on Earth is unknown; give --gps, --georef CSV, --control CSV "
        "or, if it stands on Earth already, --frame");
  }
}

PlacedReconstruction ReadSession(const SessionArguments& arguments) {
  WarnOfFuture(arguments.options.ingest.recorded_at);
  PlacedReconstruction session;
  session.reconstruction = ReadReconstruction(arguments);
  session.georegistration = GeoregisterByArguments(session.reconstruction, arguments.reconstruction,
                                                   arguments.options.georegister);
  session.options = arguments.options.ingest;
  IngestOptions& options = session.options;
  options.session_name = SessionNameOf(arguments);
  options.source = arguments.reconstruction.model_dir;
  options.joining = arguments.apart ? SessionJoining::kApart : SessionJoining::kJoin;
  options.georef_median_residual_m = session.georegistration.median_residual_m;
  if (options.agreement.position_accuracy_m == 0.0) {
    options.agreement.position_accuracy_m = session.georegistration.stated_accuracy_m;
  }
  if (arguments.force) {
    options.gate.max_lost_share = 1.0;
  }
  if (options.earth_accuracy_m == 0.0) {
    options.earth_accuracy_m = session.georegistration.accuracy.position_m;
    options.earth_accuracy_rad = session.georegistration.accuracy.rotation_rad;
  }
  options.patience = PatienceOf(arguments.wait_s);
  return session;
}

}  // namespace cairn
