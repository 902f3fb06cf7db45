#include "cli/reconstruction_arguments.h"

#include <CLI/CLI.hpp>
#include <vector>

#include "cli/arguments.h"
#include "cli/height_option.h"

namespace cairn {

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
  command
      ->add_option("--gps-accuracy", arguments->gps_accuracy_m,
                   "Accuracy of the GPS priors: 68 % radius, meters")
      ->needs(gps)
      ->check(PositiveNumber())
      ->type_name("M")
      ->capture_default_str();
  AddHeightOption(command, &arguments->height,
                  "Reference of the heights of --georef or --gps: the WGS84 ellipsoid or "
                  "mean sea level (EGM96). Default: ellipsoid for --georef; msl for --gps, as in "
                  "EXIF");
}

Georegistration GeoregisterByArguments(const Reconstruction& reconstruction,
                                       const ReconstructionArguments& arguments,
                                       const GeoregisterOptions& options) {
  std::vector<CameraPosition> positions =
      arguments.use_gps ? GpsPositions(reconstruction, arguments.gps_accuracy_m)
                        : ReadCameraPositions(arguments.georef_path);
  MakeHeightsEllipsoidal(
      arguments.height.value_or(arguments.use_gps ? HeightReference::kMeanSeaLevel
                                                  : HeightReference::kEllipsoid),
      &positions);
  return Georegister(reconstruction, positions, options);
}

}  // namespace cairn
