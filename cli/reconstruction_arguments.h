// Options of `ingest` and `eval` that name a reconstruction and place it on Earth.
#ifndef CAIRN_CLI_RECONSTRUCTION_ARGUMENTS_H_
#define CAIRN_CLI_RECONSTRUCTION_ARGUMENTS_H_

#include <optional>
#include <string>

#include "cli/world_frame_option.h"
#include "core/scene/reconstruction.h"
#include "ingest/place/georegister.h"

namespace CLI {
class App;
}  // namespace CLI

namespace cairn {

struct ReconstructionArguments {
  std::string model_dir;
  std::string database_path;
  std::string georef_path;      // CSV of camera positions; empty if not given.
  bool use_gps = false;         // Take positions from the database or the photos' EXIF.
  double gps_accuracy_m = 5.0;  // Radius that contains 68 % of the positions.
  // Reference of the heights. If unset: mean sea level for GPS, which comes from EXIF, and the
  // ellipsoid for `georef_path`.
  std::optional<HeightReference> height;
  std::optional<double> camera_height_m;  // Of cameras whose positions have none.
  std::string photo_dir;                  // Empty: looked for near the database and the model.
  std::string control_path;               // CSV of control points; empty if not given.
  WorldFrameArguments frame;              // In which the model stands, if frame.frame is set.

  // Whether anything says where the model stands.
  bool HasPositions() const {
    return use_gps || !georef_path.empty() || !control_path.empty() || frame.frame.has_value();
  }
};

// Adds --model, --database, --georef, --gps, --gps-accuracy, --height, --camera-height, --control,
// --frame and --origin.
void AddReconstructionOptions(CLI::App* command, ReconstructionArguments* arguments);

// Fits the reconstruction to the positions named by the arguments, with the EXIF orientations of
// the photos that are found, or to control points; or takes the frame in which it stands. The
// result has notes about faults of the positions. Throws as CheckPositions, Georegister and
// GeoregisterByControl, and Error(kBadInput) if the cameras are not near the Earth's surface in the
// frame that is stated.
Georegistration GeoregisterByArguments(const Reconstruction& reconstruction,
                                       const ReconstructionArguments& arguments,
                                       const GeoregisterOptions& options);

}  // namespace cairn

#endif  // CAIRN_CLI_RECONSTRUCTION_ARGUMENTS_H_
