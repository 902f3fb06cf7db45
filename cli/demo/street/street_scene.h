// A textured street that can be photographed, with exact ground truth. The demo uses this world.
#ifndef CAIRN_CLI_DEMO_STREET_STREET_SCENE_H_
#define CAIRN_CLI_DEMO_STREET_STREET_SCENE_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cli/demo/street/reconstruct_known_poses.h"  // IWYU pragma: export
#include "cli/demo/street/street_photo.h"
#include "core/camera.h"
#include "core/geodesy.h"
#include "core/images/gray_image.h"
#include "core/rigid3.h"

namespace cairn {

struct StreetOptions {
  // The middle of the street, on the pavement. At the default origin, a tile border crosses the
  // street.
  Geodetic origin = Geodetic::FromDegrees(47.3769, 8.5417, 408.0);
  double heading_rad = 0.35;  // Direction of the street, counterclockwise from east.
  double length_m = 120.0;    // [40, 1000]
  double width_m = 16.0;      // Between facades, [12, 60].
  // Distance between the stops of a pass; each stop takes three photos.
  double mapping_step_m = 4.5;
  int num_queries = 12;
  int image_width_px = 640;
  int image_height_px = 480;
  double focal_px = 420.0;
  double gps_sigma_m = 3.0;  // GPS error of a photo per axis.
  // Number of trees along each pavement, with fine foliage. The rest of the street does not depend
  // on the trees, so photos with trees can be matched to a map without them. In reality, too, no
  // two photos show the same foliage.
  int num_trees = 0;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// A street of textured rectangles. The houses on both sides differ in height, color and style. They
// have windows, shops and ornaments that repeat as they do in towns, signs with text, relief that
// causes parallax, and dirt on everything. Deterministic by seed; safe to use from any thread.
class StreetScene {
 public:
  // Paints all textures, which takes about a second and a megabyte per meter of street. Throws
  // Error(kInvalidArgument) if the options are invalid.
  explicit StreetScene(const StreetOptions& options);
  ~StreetScene();

  const StreetOptions& options() const;
  // A PINHOLE camera with the principal point in the middle.
  const Camera& camera() const;

  // Renders a photo with vignetting. `photo_seed` determines the exposure and the sensor noise.
  GrayImage Render(const Rigid3d& cam_from_enu, uint64_t photo_seed = 0) const;

  // Renders the photos "<prefix>000.png" ... at the given poses on `num_threads` threads, with
  // noisy GPS positions. The result is equal for any number of threads. `progress` (may be empty)
  // receives the number of finished photos and the total; it is called from any thread, but by one
  // thread at a time.
  std::vector<StreetPhoto> TakePhotos(const std::vector<Rigid3d>& cams_from_enu,
                                      const std::string& prefix, int num_threads = 2,
                                      const std::function<void(int, int)>& progress = {}) const;

  // Poses of a mapping vehicle that drives up and down the street. Each stop takes one photo ahead
  // and one to either side.
  std::vector<Rigid3d> MappingPoses() const;
  // Poses of a phone in hand on the sidewalk. Places, height, tilt and directions differ from those
  // of the vehicle.
  std::vector<Rigid3d> QueryPoses() const;

  // Returns the distance from a point to the nearest surface of the scene, for checking
  // reconstructions.
  double DistanceToSurfaceM(const Eigen::Vector3d& x_in_enu) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_STREET_STREET_SCENE_H_
