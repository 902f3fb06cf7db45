// A textured street that can be photographed: the demo's world, with exact ground truth.
#ifndef CAIRN_LAB_STREET_STREET_SCENE_H_
#define CAIRN_LAB_STREET_STREET_SCENE_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/geodesy.h"
#include "core/rigid3.h"
#include "ingest/images/gray_image.h"
#include "lab/known_poses/reconstruct_known_poses.h"  // IWYU pragma: export
#include "lab/known_poses/street_photo.h"

namespace cairn {

struct StreetOptions {
  // The middle of the street on the pavement; by default a tile border crosses the street there.
  Geodetic origin = Geodetic::FromDegrees(47.3769, 8.5417, 408.0);
  double heading_rad = 0.35;    // Of the street, counter-clockwise from east.
  double length_m = 120.0;      // [40, 1000]
  double width_m = 16.0;        // Between facades, [12, 60].
  double mapping_step_m = 4.5;  // Between the stops of a pass; three photos a stop.
  int num_queries = 12;
  int image_width_px = 640;
  int image_height_px = 480;
  double focal_px = 420.0;
  double gps_sigma_m = 3.0;  // Of the photos' GPS, per axis.
  // Along each pavement, with fine foliage. The rest of the street does not depend on them, so that
  // photos with trees can be asked of a map without: of real ones no two photos see the same.
  int num_trees = 0;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Houses of different height, colour and style along both sides of a street, with windows, shops
// and ornaments that repeat as they do in towns, signs with text, relief that gives parallax, and
// dirt on everything, as textured rectangles. Deterministic by seed; safe to use from any thread.
class StreetScene {
 public:
  // Throws Error(kInvalidArgument) on options that make no sense. Paints all textures: takes about
  // a second and a megabyte per metre of street.
  explicit StreetScene(const StreetOptions& options);
  ~StreetScene();

  const StreetOptions& options() const;
  // PINHOLE, with the principal point in the middle.
  const Camera& camera() const;

  // A photo with vignetting, and with exposure and sensor noise that depend on `photo_seed`.
  GrayImage Render(const Rigid3d& cam_from_enu, uint64_t photo_seed = 0) const;

  // Photos "<prefix>000.png" ... at the poses, on `num_threads` threads, with noisy GPS. Equal for
  // any number of threads. `progress` (may be empty) gets photos done and total, from any thread
  // but one at a time.
  std::vector<StreetPhoto> TakePhotos(const std::vector<Rigid3d>& cams_from_enu,
                                      const std::string& prefix, int num_threads = 2,
                                      const std::function<void(int, int)>& progress = {}) const;

  // Camera passes of a mapping vehicle: up and down the street, at each stop one photo ahead and
  // one to either side.
  std::vector<Rigid3d> MappingPoses() const;
  // A walk on the sidewalk with the phone in hand: other places, height, tilt and directions than
  // the vehicle.
  std::vector<Rigid3d> QueryPoses() const;

  // From a point to the nearest surface of the scene; for checking reconstructions.
  double DistanceToSurfaceM(const Eigen::Vector3d& x_in_enu) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_STREET_STREET_SCENE_H_
