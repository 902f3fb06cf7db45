// `cairn ingest`: adds a reconstruction to a map as one session.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/choice_option.h"
#include "cli/options_file.h"
#include "cli/reconstruction_arguments.h"
#include "cli/shell.h"
#include "core/error.h"
#include "core/printable.h"
#include "ingest/ingest_session.h"
#include "ingest/readers/colmap_reader.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct IngestArguments {
  std::string map_path;
  ReconstructionArguments reconstruction;
  std::string image_list_path;
  CairnOptions options;
  bool json = false;
};

// COLMAP projects keep their database in the top folder, so the name of that folder usually names
// the project.
std::string DefaultSessionName(const std::string& database_path) {
  const auto folder = std::filesystem::absolute(database_path).parent_path().filename().string();
  return folder.empty() ? "session" : folder;
}

void PrintJson(const IngestOptions& options, const Georegistration& georegistration,
               const IngestReport& report) {
  const nlohmann::ordered_json json = {{"session", options.session_name},
                                       {"replacedSession", report.replaced_session},
                                       {"georegistration",
                                        {{"positions", georegistration.num_positions},
                                         {"inliers", georegistration.num_inliers},
                                         {"medianResidualM", georegistration.median_residual_m},
                                         {"maxResidualM", georegistration.max_residual_m}}},
                                       {"images", report.num_images},
                                       {"landmarksRead", report.num_landmarks_read},
                                       {"landmarksDropped", report.num_landmarks_dropped},
                                       {"tiles", report.num_tiles_written},
                                       {"landmarks", report.num_landmarks_written},
                                       {"descriptors", report.num_descriptors_written},
                                       {"payloadBytes", report.num_payload_bytes},
                                       {"mapVersion", Value(report.map_version)}};
  fmt::print("{}\n", json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace));
}

void PrintText(const IngestOptions& options, const Georegistration& georegistration,
               const IngestReport& report) {
  fmt::print("session          {}{}\n", Excerpt(options.session_name),
             report.replaced_session ? " (replaced)" : "");
  fmt::print("images           {}\n", report.num_images);
  fmt::print(
      "georegistration  {} of {} positions agree; residual {:.3f} m median, {:.3f} m largest\n",
      georegistration.num_inliers, georegistration.num_positions, georegistration.median_residual_m,
      georegistration.max_residual_m);
  fmt::print(
      "landmarks        {} read, {} dropped as uncertain, {} written (once for each tile that "
      "observes them)\n",
      report.num_landmarks_read, report.num_landmarks_dropped, report.num_landmarks_written);
  fmt::print("descriptors      {}\n", report.num_descriptors_written);
  fmt::print("tiles            {} ({:.1f} kB)\n", report.num_tiles_written,
             1e-3 * static_cast<double>(report.num_payload_bytes));
  fmt::print("map version      {}\n", Value(report.map_version));
}

Reconstruction ReadReconstruction(const IngestArguments& arguments) {
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

ExitCode RunIngest(const IngestArguments& arguments, ProgressMode progress_mode) {
  if (!arguments.reconstruction.HasPositions()) {
    throw Error(ErrorCode::kInvalidArgument,
                "the position of the model on Earth is unknown; give --georef CSV or --gps");
  }
  // Open the map first, so that an unwritable map fails before the long read.
  MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadWrite);
  const Reconstruction reconstruction = ReadReconstruction(arguments);
  const Georegistration georegistration = GeoregisterByArguments(
      reconstruction, arguments.reconstruction, arguments.options.georegister);

  IngestOptions options = arguments.options.ingest;
  if (options.session_name.empty()) {
    options.session_name = DefaultSessionName(arguments.reconstruction.database_path);
  }
  options.source = arguments.reconstruction.model_dir;
  options.georef_median_residual_m = georegistration.median_residual_m;
  IngestReport report;
  {
    Progress progress(progress_mode);
    report = IngestSession(reconstruction, georegistration.ecef_from_world, options, &store,
                           [&](const char* phase, int64_t done, int64_t total) {
                             progress.Update(phase, done, total);
                           });
  }
  if (arguments.json) {
    PrintJson(options, georegistration, report);
  } else {
    PrintText(options, georegistration, report);
  }
  return ExitCode::kOk;
}

}  // namespace

void AddIngestCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("ingest", "Add a COLMAP reconstruction to a map");
  auto arguments = std::make_shared<IngestArguments>();
  IngestOptions& options = arguments->options.ingest;
  command->add_option("MAP", arguments->map_path, "Map file")->required();
  AddOptionsFile(command, &arguments->options);
  AddReconstructionOptions(command, &arguments->reconstruction);
  command->get_option("--model")->required();
  command->get_option("--database")->required();
  command
      ->add_option("--images", arguments->image_list_path,
                   "File with the images of the model to use, one name per line. Default: all")
      ->type_name("FILE");
  command
      ->add_option("--session", options.session_name,
                   "Name of the session. Replaces an existing session of that name. Default: the "
                   "folder of the database")
      ->type_name("NAME");
  command
      ->add_option("--max-descriptors", options.selection.max_descriptors,
                   "Maximum number of descriptors per tile")
      ->capture_default_str();
  AddChoiceOption(command, "--selection",
                  NamedChoice(&options.selection.kind, kLandmarkSelectionNames),
                  "How the landmarks of a tile are selected: the most observed, or, with coverage, "
                  "by the paper's integer program, which leaves enough to each keyframe");
  command
      ->add_option("--code-bytes", options.codebook.num_subspaces,
                   "Bytes per descriptor; used only for the first session of a map")
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "Print the summary as JSON");
  command->footer(
      "Example:\n"
      "  cairn ingest city.gpkg --model sparse/0 --database database.db --gps --session monday");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunIngest(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
