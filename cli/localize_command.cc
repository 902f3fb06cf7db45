// `cairn localize`: computes where a photo was taken.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/height_option.h"
#include "cli/index_option.h"
#include "cli/localize_arguments.h"
#include "cli/options_file.h"
#include "cli/rig_photos.h"
#include "cli/shell.h"
#include "core/angles.h"
#include "core/camera_of_this_size.h"
#include "core/error.h"
#include "core/features/sift/sift_extractor.h"
#include "core/geodesy.h"
#include "core/geoid.h"
#include "engine/localizer.h"
#include "eval/pictures/picture_format.h"
#include "eval/pictures/pictures.h"
#include "http/json/localize_response.h"

namespace cairn {
namespace {

// A rig needs the focal length of its first camera.
void SettleFocalOfRig(const LocalizeArguments& arguments, LocalizeQuery* query) {
  if (query->focal && !arguments.rig_path.empty()) {
    if (query->focal->with_distortion) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{} does not state its focal length, but a rig needs it; "
                              "give --camera MODEL,width,height,param,...",
                              arguments.image_path));
    }
    query->focal.reset();
  }
}

LocalizeResult Answer(const LocalizeArguments& arguments, const Photo& photo,
                      ImageOrientation orientation, const std::vector<RigPhoto>& others,
                      LocalizeQuery* query) {
  if (!arguments.server_url.empty()) {
    std::vector<std::vector<uint8_t>> images = {photo.bytes};
    for (const RigPhoto& other : others) {
      images.push_back(other.photo.bytes);
    }
    // For a rig, the sizes of the cameras determine the orientation.
    return LocalizeClient(
               ClientOptionsOf(arguments, others.empty() ? orientation : ImageOrientation::kAsSize))
        .LocalizeImages(*query, images);
  }
  const Localizer localizer = Localizer::Open(arguments.map_path, arguments.options.localizer);
  const SiftExtractor extractor(arguments.options.sift);
  query->features = extractor.Extract(photo.image);
  for (size_t i = 0; i < others.size(); ++i) {
    query->other_cameras[i].features = extractor.Extract(others[i].photo.image);
  }
  return localizer.Localize(*query);
}

void PrintCamera(const Camera& stated, const CameraEstimate& estimate) {
  const bool is_turned = HasAxesExchanged(stated, estimate.camera);
  fmt::print("focal length {:.1f} +- {:.1f} px; {} {:.1f} +- {:.1f} px\n",
             estimate.camera.focal_px(), estimate.focal_sigma_px,
             estimate.focal_disagrees && !is_turned ? "contradicts the assumed" : "assumed:",
             estimate.assumed_focal_px, estimate.assumed_focal_sigma_px);
  if (is_turned) {
    fmt::print("camera       fits the photo only with x and y exchanged: check which side is up\n");
  }
  if (estimate.is_off_center) {
    const Eigen::Vector2d axis_px = PrincipalPointPx(estimate.camera);
    fmt::print(
        "off center   the optical axis meets pixel {:.0f}, {:.0f} of {} x {}: the photo was cut "
        "out of another\n",
        axis_px.x(), axis_px.y(), estimate.camera.width_px(), estimate.camera.height_px());
  }
}

void PrintPose(const Camera& stated, const LocalizeResult& result) {
  const Rigid3d enu_from_cam =
      EcefFromEnu(result.position).Inverse() * result.cam_from_ecef.Inverse();
  const Eigen::Vector3d forward = enu_from_cam.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d right = enu_from_cam.rotation * Eigen::Vector3d::UnitX();
  const double heading_deg = std::atan2(forward.x(), forward.y()) * kDegPerRad;
  fmt::print("position     {:.8f} {:.8f} {:.3f}  (latitude, longitude, ellipsoidal height)\n",
             result.position.lat_deg(), result.position.lon_deg(), result.position.h_m);
  fmt::print(
      "heading      {:.2f} deg from north, looking {:.2f} deg up, right side {:.2f} deg up\n",
      heading_deg < 0.0 ? heading_deg + 360.0 : heading_deg,
      std::asin(std::clamp(forward.z(), -1.0, 1.0)) * kDegPerRad,
      std::asin(std::clamp(right.z(), -1.0, 1.0)) * kDegPerRad);
  fmt::print(
      "accuracy     {:.3f} m, {:.3f} deg in the map; {:.3f} m, {:.3f} deg on Earth  (68 %)\n",
      result.position_accuracy_m, result.rotation_accuracy_rad * kDegPerRad,
      result.EarthAccuracyM(), result.EarthAccuracyRad() * kDegPerRad);
  if (result.camera) {
    PrintCamera(stated, *result.camera);
  }
  fmt::print("confidence   {:.3f}\n", result.confidence);
  fmt::print("evidence     score {:.1f}; probability by chance {:.1g}\n", result.score,
             result.false_alarm_rate);
  const double num_right = std::accumulate(
      result.matches.begin(), result.matches.end(), 0.0,
      [](double sum, const LocalizeMatch& match) { return sum + match.right_probability; });
  fmt::print("inliers      {} (about {:.0f} correct)\n", result.matches.size(), num_right);
  if (result.prior_disagrees) {
    fmt::print("prior        disagrees with the answer:\n");
  }
}

void PrintPrior(const std::optional<PositionPrior>& prior) {
  if (!prior) {
    fmt::print("prior        none; the map was searched\n");
    return;
  }
  fmt::print("prior        {:.6f} {:.6f} +- {:.0f} m, from {}\n", prior->position.lat_deg(),
             prior->position.lon_deg(), prior->accuracy_m,
             prior->source == PriorSource::kPhoto ? "the photo's EXIF" : "--prior");
}

void PrintText(const LocalizeQuery& query, const LocalizeResult& result) {
  if (result.localized) {
    PrintPose(query.camera, result);
  } else {
    fmt::print("not localized: {}{}{}\n", NotLocalizedReasonName(result.reason),
               result.reason_text.empty() ? "" : ": ", result.reason_text);
  }
  PrintPrior(query.prior);
  const StageCounters& counters = result.counters;
  fmt::print("searched     {} keypoints, {} of {} tiles, {} matches, {} candidates\n",
             counters.num_keypoints, counters.num_tiles_searched, counters.num_tiles_found,
             counters.num_matches, counters.num_candidates);
  if (!counters.used_prior) {
    fmt::print("no prior     {} places of the map that look most like the photo were searched\n",
               counters.num_places_searched);
  }
  fmt::print("time         {:.1f} ms:", 1e3 * result.times.total_seconds);
  for (int stage = 0; stage < kNumStages; ++stage) {
    fmt::print(" {} {:.1f}", StageName(static_cast<Stage>(stage)),
               1e3 * result.times.seconds[stage]);
  }
  fmt::print("\n");
}

ExitCode RunLocalizePhoto(const LocalizeArguments& arguments) {
  if (!arguments.picture_path.empty()) {
    RequirePictureFormat("--picture", arguments.picture_path);
  }
  auto [photo, orientation, query] =
      ReadPhotoQuery(arguments.image_path, QueryOptionsOf(arguments));
  SettleFocalOfRig(arguments, &query);
  std::vector<RigPhoto> others;
  if (!arguments.rig_path.empty()) {
    others = ReadRigPhotos(arguments.rig_path);
  }
  for (const RigPhoto& other : others) {
    query.other_cameras.push_back(other.camera);
  }
  const LocalizeResult result = Answer(arguments, photo, orientation, others, &query);
  if (!arguments.picture_path.empty()) {
    DrawMatches(arguments.picture_path, photo.image, query, result);
  }
  if (arguments.json) {
    LocalizeRequest request;
    request.query = query;
    request.answer.with_matches = true;
    fmt::print("{}\n", LocalizeResponseJson(result, request, ServerTimes()));
  } else {
    PrintText(query, result);
  }
  return result.localized ? ExitCode::kOk : ExitCode::kNotLocalized;
}

ExitCode RunLocalize(const LocalizeArguments& arguments, ProgressMode progress_mode) {
  const auto require = [](bool holds, const char* message) {
    if (!holds) {
      throw Error(ErrorCode::kInvalidArgument, message);
    }
  };
  const bool has_image = !arguments.image_path.empty();
  const bool has_images = !arguments.batch.images.empty();
  require(arguments.map_path.empty() != arguments.server_url.empty(),
          "give either a MAP or --server URL");
  require(has_image != has_images, "give either --image FILE or, for many photos, --images");
  require(!arguments.height || arguments.prior || !arguments.batch.gps_path.empty(),
          "--height is that of --prior or --gps");
  return has_images ? RunLocalizeBatch(arguments, progress_mode) : RunLocalizePhoto(arguments);
}

void AddQueryOptions(CLI::App* command, LocalizeArguments* arguments) {
  command->add_option("--image", arguments->image_path, "Photo (JPEG, PNG or binary PNM)")
      ->type_name("FILE");
  command
      ->add_option("--camera", arguments->camera,
                   "Intrinsics as a COLMAP model, in pixels, for the photo as stored or as turned "
                   "by its EXIF, whichever has size w x h. Default: from the EXIF focal length, "
                   "for the upright photo; without an EXIF focal length, estimated with the pose")
      ->type_name("MODEL,w,h,param,...");
  command
      ->add_option(
          "--focal-sigma", arguments->focal_sigma_percent,
          "Standard deviation of the focal length of --camera or EXIF, percent. Default: "
          "5 for EXIF; the focal length of --camera is fixed unless the photo contradicts it")
      ->check(NumberWithin(100.0 * FocalPrior::kMinLogSigma, 100.0 * FocalPrior::kMaxLogSigma))
      ->type_name("PCT");
  command
      ->add_option(
          "--rig", arguments->rig_path,
          "JSON file of the photos that the rig's other cameras took at the same instant, like rig "
          "in docs/http.md but with file paths as image. The answer is the pose of --image")
      ->type_name("FILE.json");
  command
      ->add_option("--prior", arguments->prior,
                   "Approximate position, degrees and meters. Default: the position in the photo's "
                   "EXIF, if there is one")
      ->type_name("lat,lon[,h]");
  AddHeightOption(command, &arguments->height,
                  "Reference of the heights in --prior and --gps: the WGS84 ellipsoid or mean sea "
                  "level (EGM96). Default: ellipsoid");
  command
      ->add_option("--accuracy", arguments->accuracy_m,
                   "Accuracy of --prior, and of rows of --gps that state none: 68 % radius, meters")
      ->check(PositiveNumber())
      ->type_name("M")
      ->capture_default_str();
  command->add_flag("!--no-exif-prior", arguments->exif_prior,
                    "Without --prior, search the whole map instead of the surroundings of the "
                    "position in the photo's EXIF");
  command
      ->add_option("--gravity", arguments->gravity,
                   "Down direction in the camera frame (x right, y down, z forward) of that photo")
      ->type_name("x,y,z");
}

}  // namespace

PhotoQueryOptions QueryOptionsOf(const LocalizeArguments& arguments) {
  PhotoQueryOptions options;
  if (arguments.camera) {
    options.camera = ParseCamera("--camera", *arguments.camera);
  }
  if (arguments.focal_sigma_percent) {
    options.focal_log_sigma = 0.01 * *arguments.focal_sigma_percent;
  }
  if (arguments.prior) {
    options.prior.emplace();
    options.prior->position =
        WithEllipsoidalHeight(ParsePlace("--prior", *arguments.prior),
                              arguments.height.value_or(HeightReference::kEllipsoid));
    options.prior->accuracy_m = arguments.accuracy_m;
  }
  options.exif_prior = arguments.exif_prior;
  if (arguments.gravity) {
    options.down_in_cam = ParseDirection("--gravity", *arguments.gravity);
  }
  return options;
}

ClientOptions ClientOptionsOf(const LocalizeArguments& arguments, ImageOrientation orientation) {
  return {.url = arguments.server_url,
          .ca_file = arguments.ca_file,
          .api_key = arguments.key.Read(),
          .allow_plain_key = arguments.key.allow_plain,
          .image_orientation = orientation,
          .exif_prior = arguments.exif_prior};
}

void AddLocalizeCommand(CLI::App* app, Shell* shell) {
  CLI::App* command =
      app->add_subcommand("localize", "Compute where a photo, or each of many, was taken");
  auto arguments = std::make_shared<LocalizeArguments>();
  command->add_option("MAP", arguments->map_path,
                      "Map: a file or a postgresql:// URL; omit with --server");
  auto* const server =
      command
          ->add_option("--server", arguments->server_url, "Query this server instead of a map file")
          ->type_name("URL");
  AddCaOption(command, server, &arguments->ca_file);
  AddClientKeyOptions(command, server, &arguments->key);
  AddOptionsFile(command, &arguments->options);
  AddQueryOptions(command, arguments.get());
  AddBatchOptions(command, &arguments->batch);
  AddSeedOption(command, &arguments->options.localizer.seed,
                "Random seed (no effect with --server)");
  AddIndexOption(command, &arguments->options.localizer.matching.index.kind);
  command->add_flag("--json", arguments->json,
                    "Print the answer as JSON, like the server; with --images the summary");
  command
      ->add_option("--picture", arguments->picture_path, "Write a picture of the matched keypoints")
      ->type_name("FILE.png");
  command->footer(
      "The exit code is 3 if no pose was found.\n"
      "Example:\n"
      "  cairn localize city.gpkg --image photo.jpg --prior 47.3769,8.5417,408 --accuracy 15 \\\n"
      "    --gravity 0,1,0\n"
      "  cairn localize city.gpkg --images photos/ --output poses.csv");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunLocalize(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
