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
#include "core/angles.h"
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
  bool apart = false;
  bool json = false;
};

// COLMAP projects keep their database in the top folder, so the name of that folder usually names
// the project.
std::string DefaultSessionName(const std::string& database_path) {
  const auto folder = std::filesystem::absolute(database_path).parent_path().filename().string();
  return folder.empty() ? "session" : folder;
}

nlohmann::ordered_json ComparisonJson(const MapComparison& comparison) {
  return {{"photosExpected", comparison.num_expected},
          {"photosRecognised", comparison.num_localized},
          {"photosAgreeing", comparison.fit.num_agreeing},
          {"movedM", comparison.fit.moved_m},
          {"turnedDeg", comparison.fit.turned_rad * kDegPerRad},
          {"scale", comparison.fit.scale},
          {"medianResidualM", comparison.fit.median_residual_m}};
}

nlohmann::ordered_json ChangesJson(const TileChanges& changes) {
  return {{"merged", changes.num_merged},
          {"new", changes.num_new},
          {"notNeeded", changes.num_not_needed},
          {"faded", changes.num_faded},
          {"evicted", changes.num_evicted},
          {"keyframesReplaced", changes.num_keyframes_replaced},
          {"bytesBefore", changes.num_bytes_before},
          {"bytesAfter", changes.num_bytes_after}};
}

void PrintJson(const IngestOptions& options, const Georegistration& georegistration,
               const IngestReport& report) {
  const nlohmann::ordered_json json = {{"session", options.session_name},
                                       {"replacedSession", report.replaced_session},
                                       {"unchanged", report.is_unchanged},
                                       {"georegistration",
                                        {{"positions", georegistration.num_positions},
                                         {"inliers", georegistration.num_inliers},
                                         {"medianResidualM", georegistration.median_residual_m},
                                         {"maxResidualM", georegistration.max_residual_m}}},
                                       {"comparison", ComparisonJson(report.comparison)},
                                       {"images", report.num_images},
                                       {"landmarksRead", report.num_landmarks_read},
                                       {"landmarksDropped", report.num_landmarks_dropped},
                                       {"changes", ChangesJson(report.changes)},
                                       {"tiles", report.num_tiles_written},
                                       {"landmarks", report.num_landmarks_written},
                                       {"descriptors", report.num_descriptors_written},
                                       {"payloadBytes", report.num_payload_bytes},
                                       {"mapVersion", Value(report.map_version)}};
  fmt::print("{}\n", json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace));
}

void PrintComparison(const MapComparison& comparison) {
  if (comparison.num_expected == 0) {
    return;
  }
  fmt::print(
      "comparison       the map recognizes {} of {} photos; {} agree on a move of {:.2f} m and "
      "{:.2f} degrees, residual {:.3f} m median\n",
      comparison.num_localized, comparison.num_expected, comparison.fit.num_agreeing,
      comparison.fit.moved_m, comparison.fit.turned_rad * kDegPerRad,
      comparison.fit.median_residual_m);
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
  if (report.is_unchanged) {
    fmt::print("The map already holds exactly this session. Nothing was changed.\n");
    return;
  }
  PrintComparison(report.comparison);
  fmt::print("landmarks        {} read, {} dropped as uncertain\n", report.num_landmarks_read,
             report.num_landmarks_dropped);
  const TileChanges& changes = report.changes;
  fmt::print(
      "                 {} merged, {} new, {} not needed, {} faded, {} evicted (one count for each "
      "tile)\n",
      changes.num_merged, changes.num_new, changes.num_not_needed, changes.num_faded,
      changes.num_evicted);
  fmt::print("keyframes        {} replaced\n", changes.num_keyframes_replaced);
  fmt::print(
      "tiles            {} with {} landmarks and {} descriptors; {:.1f} kB before, {:.1f} kB "
      "now\n",
      report.num_tiles_written, report.num_landmarks_written, report.num_descriptors_written,
      1e-3 * static_cast<double>(changes.num_bytes_before),
      1e-3 * static_cast<double>(changes.num_bytes_after));
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
  options.joining = arguments.apart ? SessionJoining::kApart : SessionJoining::kJoin;
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
  command
      ->add_option("--recorded", options.recorded_at,
                   "When the photos were taken, e.g. 2026-01-31T12:00:00Z. Default: now. Landmarks "
                   "that later sessions miss fade with time")
      ->type_name("UTC");
  command->add_flag(
      "--apart", arguments->apart,
      "Do not compare the session with the map, and keep its landmarks beside those of the map");
  command->add_flag("--json", arguments->json, "Print the summary as JSON");
  command->footer(
      "Example:\n"
      "  cairn ingest city.gpkg --model sparse/0 --database database.db --gps --session monday");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunIngest(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
