#include "cli/reconstruction_arguments.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/height_option.h"
#include "cli/model_photos.h"
#include "core/error.h"
#include "core/printable.h"
#include "ingest/place/control_points.h"
#include "ingest/place/position_checks.h"

namespace cairn {
namespace {

// Sentences about what was left out.
std::vector<std::string> NotesOn(const Reconstruction& reconstruction,
                                 const PositionFindings& findings,
                                 const Georegistration& georegistration) {
  std::vector<std::string> notes;
  const size_t num_images = reconstruction.images.size();
  if (static_cast<size_t>(georegistration.num_positions) < num_images) {
    notes.push_back(fmt::format("{} of {} photos have no position, or one that cannot be",
                                num_images - static_cast<size_t>(georegistration.num_positions),
                                num_images));
  }
  std::ranges::move(NotesOnPositions(findings), std::back_inserter(notes));
  std::ranges::move(NotesOnOutliers(georegistration), std::back_inserter(notes));
  return notes;
}

// Takes out the positions that receivers marked as void, and says how many.
void DropVoid(const Reconstruction& reconstruction, const PhotoExif& exif,
              std::vector<CameraPosition>* positions, std::vector<std::string>* notes) {
  std::set<std::string> void_names;
  for (size_t i = 0; i < exif.gps_is_void.size(); ++i) {
    if (exif.gps_is_void[i]) {
      void_names.insert(reconstruction.images[i].name);
    }
  }
  const size_t num_dropped = std::erase_if(*positions, [&](const CameraPosition& position) {
    return void_names.contains(position.image_name);
  });
  if (num_dropped > 0) {
    notes->push_back(fmt::format(
        "{} positions that the receiver marked as void (GPSStatus V) are left out", num_dropped));
  }
}

// The positions in the database, without those that the photos know to be void.
std::vector<CameraPosition> GpsOfDatabase(const Reconstruction& reconstruction,
                                          const ReconstructionArguments& arguments,
                                          const PhotoExif& exif, std::vector<std::string>* notes) {
  std::vector<CameraPosition> positions = GpsPositions(reconstruction, arguments.gps_accuracy_m);
  DropVoid(reconstruction, exif, &positions, notes);
  if (positions.empty()) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: none of the {} images has a GPS position here, so the place of "
                            "the model on Earth is unknown. Photos without GPS need known "
                            "positions of three images or more: --georef CSV; or control points: "
                            "--control CSV; or a model that stands on Earth already: --frame{}",
                            arguments.database_path, reconstruction.images.size(),
                            notes->empty() ? "" : fmt::format(" ({})", notes->front())));
  }
  return positions;
}

std::vector<CameraPosition> PositionsOfTable(const Reconstruction& reconstruction,
                                             const ReconstructionArguments& arguments,
                                             std::vector<std::string>* notes) {
  std::vector<CameraPosition> positions = ReadCameraPositions(arguments.georef_path);
  try {
    if (const auto note = NameAfterImages(reconstruction, &positions)) {
      notes->push_back(*note);
    }
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{}: {}", arguments.georef_path, error.what()));
  }
  return positions;
}

// The model stands on Earth already.
Georegistration PlaceByFrame(const Reconstruction& reconstruction,
                             const WorldFrameArguments& frame) {
  if (frame.frame == FrameChoice::kEnu && frame.origin.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                "--frame enu needs --origin LAT,LON,H, the place of the model's origin");
  }
  Georegistration result;
  result.ecef_from_world = WorldFrameOf(frame, FrameChoice::kEcef, nullptr).ecef_from_world;
  for (const ReconImage& image : reconstruction.images) {
    const Eigen::Vector3d center = image.cam_from_world.Inverse().translation;
    const Geodetic position = GeodeticFromEcef(result.ecef_from_world * center);
    if (position.h_m < Geodetic::kMinHeightM || position.h_m > Geodetic::kMaxHeightM) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("the model does not stand in the stated frame: {} would be {:.0f} km "
                              "above the ellipsoid",
                              Excerpt(image.name), 1e-3 * position.h_m));
    }
  }
  result.up.source = "--frame";
  return result;
}

Georegistration PlaceByControl(const Reconstruction& reconstruction,
                               const ReconstructionArguments& arguments,
                               const GeoregisterOptions& options) {
  std::vector<ControlPoint> points = ReadControlPoints(arguments.control_path);
  MakeHeightsEllipsoidal(arguments.height, &points);
  Georegistration result = GeoregisterByControl(reconstruction, points, options);
  const int num_outliers = result.num_positions - result.num_inliers;
  if (num_outliers > 0) {
    result.notes.push_back(fmt::format(
        "{} control points disagree and do not count; {} is {:.2f} m from where the photos say",
        num_outliers, Excerpt(result.worst_image), result.max_residual_m));
  }
  return result;
}

}  // namespace

void AddReconstructionOptions(CLI::App* command, ReconstructionArguments* arguments) {
  command
      ->add_option("--model", arguments->model_dir,
                   "Folder of the COLMAP sparse model, e.g. sparse/0")
      ->type_name("DIR");
  command
      ->add_option("--database", arguments->database_path,
                   "COLMAP database with the keypoints and descriptors of the model")
      ->type_name("FILE");
  CLI::Option* georef =
      command
          ->add_option(
              "--georef", arguments->georef_path,
              "CSV of camera positions: image,lat_deg,lon_deg,h_m[,accuracy_m]; see --height")
          ->type_name("CSV");
  CLI::Option* gps = command->add_flag("--gps", arguments->use_gps,
                                       "Take camera positions from the GPS priors in the database");
  georef->excludes(gps);
  CLI::Option* control =
      command
          ->add_option("--control", arguments->control_path,
                       "CSV of surveyed points that photos show, a row for each photo: point,"
                       "lat_deg,lon_deg,h_m,image,x_px,y_px[,accuracy_m]; see --height")
          ->type_name("CSV")
          ->excludes(georef)
          ->excludes(gps);
  AddModelFrameOptions(command, &arguments->frame);
  command->get_option("--frame")->excludes(georef)->excludes(gps)->excludes(control);
  command
      ->add_option("--gps-accuracy", arguments->gps_accuracy_m,
                   "Accuracy of the GPS priors: 68 % radius, meters")
      ->needs(gps)
      ->check(PositiveNumber())
      ->type_name("M")
      ->capture_default_str();
  AddHeightOption(
      command, &arguments->height,
      "Reference of the heights of --georef, --control or --gps: the WGS84 ellipsoid or "
      "mean sea level (EGM96). Default: ellipsoid; msl for --gps, as in EXIF");
  command
      ->add_option("--camera-height", arguments->camera_height_m,
                   "Height of the cameras whose positions have none, with the reference of "
                   "--height. Default: that of the others")
      ->check(NumberWithin(-12'000.0, 12'000.0))
      ->type_name("M");
}

Georegistration GeoregisterByArguments(const Reconstruction& reconstruction,
                                       const ReconstructionArguments& arguments,
                                       const GeoregisterOptions& options) {
  if (!arguments.photo_dir.empty()) {
    CheckPhotoFolder(arguments.photo_dir, reconstruction);
  }
  if (arguments.frame.frame) {
    return PlaceByFrame(reconstruction, arguments.frame);
  }
  if (!arguments.control_path.empty()) {
    return PlaceByControl(reconstruction, arguments, options);
  }
  const std::string folder =
      arguments.photo_dir.empty()
          ? FindPhotoFolder(reconstruction, arguments.database_path, arguments.model_dir)
          : arguments.photo_dir;
  const PhotoExif exif = folder.empty() ? PhotoExif() : ReadPhotoExif(folder, reconstruction);
  std::vector<std::string> notes;
  std::vector<CameraPosition> positions =
      arguments.use_gps ? GpsOfDatabase(reconstruction, arguments, exif, &notes)
                        : PositionsOfTable(reconstruction, arguments, &notes);
  if (!arguments.use_gps) {
    const auto note = CompareWithExif(arguments.georef_path, positions,
                                      GpsPositions(reconstruction, arguments.gps_accuracy_m));
    if (note) {
      notes.push_back(*note);
    }
  }
  const PositionFindings findings = CheckPositions(arguments.camera_height_m, &positions);
  MakeHeightsEllipsoidal(
      arguments.height,
      arguments.use_gps ? HeightReference::kMeanSeaLevel : HeightReference::kEllipsoid, &positions);
  Georegistration result = Georegister(reconstruction, positions, options, exif.orientations);
  result.notes = NotesOn(reconstruction, findings, result);
  std::ranges::move(notes, std::back_inserter(result.notes));
  return result;
}

}  // namespace cairn
