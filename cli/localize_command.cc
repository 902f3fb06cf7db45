// `cairn localize`: where was this photo taken?
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/arguments.h"
#include "cli/height_option.h"
#include "cli/index_option.h"
#include "cli/open_localizer.h"
#include "cli/rig_photos.h"
#include "cli/shell.h"
#include "core/error.h"
#include "core/focal_length.h"
#include "core/geodesy.h"
#include "core/geoid.h"
#include "eval/pictures/picture_format.h"
#include "eval/pictures/pictures.h"
#include "http/client.h"
#include "http/json/image_orientation.h"
#include "http/json/localize_response.h"
#include "ingest/features/sift_extractor.h"
#include "ingest/images/exif.h"
#include "ingest/images/orient_image.h"
#include "ingest/images/photo_camera.h"

namespace cairn {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;

struct LocalizeArguments {
  std::string map_path;
  std::string server_url;
  std::string image_path;
  std::string rig_path;  // Empty: one camera.
  std::optional<std::string> camera;
  std::optional<double> focal_sigma_percent;
  std::optional<std::string> prior;
  std::optional<HeightReference> prior_height;
  double accuracy_m = 15.0;
  std::optional<std::string> gravity;
  std::string picture_path;
  uint64_t seed = 1;
  IndexKind index = IndexOptions().kind;
  bool json = false;
};

// The photo turned so that it is the picture of --camera, or upright as EXIF has it without one;
// returns which of the two it is.
ImageOrientation TurnPhoto(const std::optional<Camera>& camera, const ExifInfo& exif,
                           GrayImage* photo) {
  const PictureHeader header{photo->width_px, photo->height_px, exif.orientation};
  const int orientation = camera ? OrientationToApply(header, ImageOrientation::kAsSize,
                                                      camera->width_px(), camera->height_px())
                                 : exif.orientation;
  *photo = OrientImage(std::move(*photo), orientation);
  return orientation == 1 ? ImageOrientation::kStored : ImageOrientation::kUpright;
}

LocalizeQuery MakeQuery(const LocalizeArguments& arguments, const std::optional<Camera>& camera,
                        const ExifInfo& exif, const GrayImage& pixels) {
  LocalizeQuery query;
  query.id = arguments.image_path;
  if (camera) {
    query.camera = *camera;
  } else {
    PhotoCamera of_photo = CameraOfPhoto(exif, pixels.width_px, pixels.height_px);
    query.camera = std::move(of_photo.camera);
    query.focal = of_photo.focal;
  }
  if (arguments.focal_sigma_percent) {
    query.focal = FocalPrior{.log_sigma = 0.01 * *arguments.focal_sigma_percent};
  }
  if (query.focal && !arguments.rig_path.empty()) {
    if (query.focal->with_distortion) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{} does not say its focal length, which the cameras of a rig need; "
                              "give --camera MODEL,width,height,param,...",
                              arguments.image_path));
    }
    query.focal.reset();
  }
  if (query.camera.width_px() != pixels.width_px || query.camera.height_px() != pixels.height_px) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{} has {} x {} pixels, but --camera says {} x {}",
                            arguments.image_path, pixels.width_px, pixels.height_px,
                            query.camera.width_px(), query.camera.height_px()));
  }
  if (arguments.prior) {
    const Geodetic position =
        WithEllipsoidalHeight(ParseGeodetic("--prior", *arguments.prior),
                              arguments.prior_height.value_or(HeightReference::kEllipsoid));
    query.prior = PositionPrior{position, arguments.accuracy_m, std::nullopt};
  }
  if (arguments.gravity) {
    query.down_in_cam = ParseDirection("--gravity", *arguments.gravity);
  }
  return query;
}

LocalizeResult Answer(const LocalizeArguments& arguments, const Photo& photo,
                      ImageOrientation orientation, const std::vector<RigPhoto>& others,
                      LocalizeQuery* query) {
  if (!arguments.server_url.empty()) {
    std::vector<std::vector<uint8_t>> images = {photo.bytes};
    for (const RigPhoto& other : others) {
      images.push_back(other.photo.bytes);
    }
    // Those of a rig have sizes that say which picture is meant.
    return LocalizeClient(ClientOptions{.url = arguments.server_url,
                                        .image_orientation = others.empty()
                                                                 ? orientation
                                                                 : ImageOrientation::kAsSize})
        .LocalizeImages(*query, images);
  }
  LocalizerOptions options;
  options.seed = arguments.seed;
  options.matching.index.kind = arguments.index;
  const OpenedMap map = OpenLocalizer(arguments.map_path, options);
  query->features = ExtractSift(photo.image);
  for (size_t i = 0; i < others.size(); ++i) {
    query->other_cameras[i].features = ExtractSift(others[i].photo.image);
  }
  return map.localizer->Localize(*query);
}

void PrintPose(const LocalizeResult& result) {
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
  fmt::print("accuracy     {:.3f} m, {:.3f} deg  (68 %)\n", result.position_accuracy_m,
             result.rotation_accuracy_rad * kDegPerRad);
  if (result.camera) {
    const CameraEstimate& camera = *result.camera;
    fmt::print("focal length {:.1f} px, standard deviation {:.1f}; {} {:.1f}, {:.1f}\n",
               camera.camera.focal_px(), camera.focal_sigma_px,
               camera.focal_disagrees ? "contradicts" : "assumed were", camera.assumed_focal_px,
               camera.assumed_focal_sigma_px);
  }
  fmt::print("confidence   {:.3f}\n", result.confidence);
  fmt::print("evidence     score {:.1f}; by chance {:.1g} of such queries score as high\n",
             result.score, result.false_alarm_rate);
  const double num_right = std::accumulate(
      result.matches.begin(), result.matches.end(), 0.0,
      [](double sum, const LocalizeMatch& match) { return sum + match.right_probability; });
  fmt::print("inliers      {} ({:.0f} of them right)\n", result.matches.size(), num_right);
  if (result.prior_disagrees) {
    fmt::print("prior        disagrees: the answer is far from it\n");
  }
}

void PrintText(const LocalizeResult& result) {
  if (result.localized) {
    PrintPose(result);
  } else {
    fmt::print("not localized: {}\n", NotLocalizedReasonName(result.reason));
  }
  const StageCounters& counters = result.counters;
  fmt::print("searched     {} keypoints, {} tiles, {} matches, {} candidates\n",
             counters.num_keypoints, counters.num_tiles_searched, counters.num_matches,
             counters.num_candidates);
  fmt::print("time         {:.1f} ms:", 1e3 * result.times.total_seconds);
  for (int stage = 0; stage < kNumStages; ++stage) {
    fmt::print(" {} {:.1f}", StageName(static_cast<Stage>(stage)),
               1e3 * result.times.seconds[stage]);
  }
  fmt::print("\n");
}

ExitCode RunLocalize(const LocalizeArguments& arguments) {
  if (arguments.map_path.empty() == arguments.server_url.empty()) {
    throw Error(ErrorCode::kInvalidArgument, "give either a MAP or --server URL");
  }
  if (!arguments.picture_path.empty()) {
    RequirePictureFormat("--picture", arguments.picture_path);
  }
  Photo photo = ReadPhoto(arguments.image_path);
  const ExifInfo exif = ReadExif(photo.bytes);
  std::optional<Camera> camera;
  if (arguments.camera) {
    camera = ParseCamera("--camera", *arguments.camera);
  }
  const ImageOrientation orientation = TurnPhoto(camera, exif, &photo.image);
  LocalizeQuery query = MakeQuery(arguments, camera, exif, photo.image);
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
    PrintText(result);
  }
  return result.localized ? ExitCode::kOk : ExitCode::kNotLocalized;
}

void AddQueryOptions(CLI::App* command, LocalizeArguments* arguments) {
  command->add_option("--image", arguments->image_path, "Photo (JPEG, PNG or binary PNM)")
      ->required()
      ->type_name("FILE");
  command
      ->add_option(
          "--camera", arguments->camera,
          "Intrinsics, COLMAP's models in pixels, of the photo as it is stored or, if w and h are "
          "those, as EXIF turns it. Default: from the EXIF focal length, of the photo "
          "upright; without one, estimated along with the pose")
      ->type_name("MODEL,w,h,param,...");
  command
      ->add_option("--focal-sigma", arguments->focal_sigma_percent,
                   "Standard deviation of the focal length of --camera or EXIF, percent. Default: "
                   "5 of EXIF; that of --camera is kept unless the photo contradicts it")
      ->check(NumberWithin(100.0 * FocalPrior::kMinLogSigma, 100.0 * FocalPrior::kMaxLogSigma))
      ->type_name("PCT");
  command
      ->add_option("--rig", arguments->rig_path,
                   "Photos that other cameras of the body took at the same instant, as the rig of "
                   "docs/http.md with a path as image; the answer is the pose of --image")
      ->type_name("FILE.json");
  CLI::Option* prior =
      command->add_option("--prior", arguments->prior, "Rough position, degrees and metres")
          ->type_name("lat,lon,h");
  AddHeightOption(command, &arguments->prior_height,
                  "What the height of --prior is measured from: the WGS84 ellipsoid or mean sea "
                  "level (EGM96). Default: ellipsoid")
      ->needs(prior);
  command->add_option("--accuracy", arguments->accuracy_m, "Metres that hold 68 % of such priors")
      ->needs(prior)
      ->check(PositiveNumber())
      ->type_name("M")
      ->capture_default_str();
  command
      ->add_option(
          "--gravity", arguments->gravity,
          "Direction of down in the camera frame (x right, y down, z forward) of that photo")
      ->type_name("x,y,z");
}

}  // namespace

void AddLocalizeCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("localize", "Say where a photo was taken");
  auto arguments = std::make_shared<LocalizeArguments>();
  command->add_option("MAP", arguments->map_path, "Map file, unless --server is given");
  command->add_option("--server", arguments->server_url, "Ask this server")->type_name("URL");
  AddQueryOptions(command, arguments.get());
  AddSeedOption(command, &arguments->seed, "Seed of everything random (not with --server)");
  AddIndexOption(command, &arguments->index);
  command->add_flag("--json", arguments->json, "Print the answer as the server's JSON");
  command->add_option("--picture", arguments->picture_path, "Draw the matched keypoints")
      ->type_name("FILE.png");
  command->footer(
      "Exits with 3 if there is no pose.\n"
      "Example:\n"
      "  cairn localize city.gpkg --image photo.jpg --prior 47.3769,8.5417,408 --accuracy 15 \\\n"
      "    --gravity 0,1,0");
  command->callback(
      [shell, arguments] { shell->run = [arguments] { return RunLocalize(*arguments); }; });
}

}  // namespace cairn
