#include "cli/reconstruction_arguments.h"

#include <CLI/CLI.hpp>
#include <vector>

#include "cli/arguments.h"
#include "cli/height_option.h"

namespace cairn {

void AddReconstructionOptions(CLI::App* command, ReconstructionArguments* arguments) {
  command->add_option("--model", arguments->model_dir, "COLMAP sparse model, e.g. sparse/0")
      ->type_name("DIR");
  command
      ->add_option("--database", arguments->database_path,
                   "COLMAP database with the model's keypoints and descriptors")
      ->type_name("FILE");
  CLI::Option* georef =
      command
          ->add_option(
              "--georef", arguments->georef_path,
              "Camera positions: CSV with image,lat_deg,lon_deg,h_m[,accuracy_m]; see --height")
          ->type_name("CSV");
  CLI::Option* gps =
      command->add_flag("--gps", arguments->use_gps, "Camera positions: the database's GPS priors");
  georef->excludes(gps);
  command
      ->add_option("--gps-accuracy", arguments->gps_accuracy_m,
                   "Metres that hold 68 % of the GPS priors")
      ->needs(gps)
      ->check(PositiveNumber())
      ->type_name("M")
      ->capture_default_str();
  AddHeightOption(command, &arguments->height,
                  "What the heights of --georef or --gps are measured from: the WGS84 ellipsoid or "
                  "mean sea level (EGM96). Default: ellipsoid for --georef; msl for --gps, as EXIF "
                  "has it");
}

Georegistration GeoregisterByArguments(const Reconstruction& reconstruction,
                                       const ReconstructionArguments& arguments) {
  std::vector<CameraPosition> positions =
      arguments.use_gps ? GpsPositions(reconstruction, arguments.gps_accuracy_m)
                        : ReadCameraPositions(arguments.georef_path);
  MakeHeightsEllipsoidal(
      arguments.height.value_or(arguments.use_gps ? HeightReference::kMeanSeaLevel
                                                  : HeightReference::kEllipsoid),
      &positions);
  return Georegister(reconstruction, positions, GeoregisterOptions());
}

}  // namespace cairn
