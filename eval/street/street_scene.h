// A textured street that can be photographed: the demo's world, with exact ground truth.
#ifndef CAIRN_EVAL_STREET_STREET_SCENE_H_
#define CAIRN_EVAL_STREET_STREET_SCENE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/geodesy.h"
#include "core/rigid3.h"
#include "ingest/features/sift_extractor.h"
#include "ingest/reconstruction.h"

namespace cairn {

struct StreetOptions {
  Geodetic origin = Geodetic::FromDegrees(47.3769, 8.5417, 408.0);
  double length_m = 120.0;
  double width_m = 16.0;           // Between facades.
  double mapping_step_m = 3.0;     // Between keyframes of a pass.
  int num_queries = 12;
  int image_width_px = 640;
  int image_height_px = 480;
  double focal_px = 420.0;
  uint64_t seed = 1;

  void Validate() const;
};

// A photograph and where it was taken.
struct StreetPhoto {
  std::string name;
  Rigid3d cam_from_enu;  // enu at the origin.
  GrayImage image;
};

// Facades with windows, doors, signs and repeated ornaments, and a paved ground, as textured
// rectangles. Deterministic by seed.
class StreetScene {
 public:
  explicit StreetScene(const StreetOptions& options);
  ~StreetScene();

  const StreetOptions& options() const;
  const Camera& camera() const;

  GrayImage Render(const Rigid3d& cam_from_enu) const;

  // Camera passes of a mapping vehicle: both directions, looking ahead and to both sides.
  std::vector<Rigid3d> MappingPoses() const;
  // A walk on the sidewalk: other side, height and direction than the vehicle.
  std::vector<Rigid3d> QueryPoses() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Real SIFT of the photos, matched between neighbouring cameras under their known epipolar geometry
// and triangulated with the known poses; world is enu at the scene's origin.
Reconstruction ReconstructWithKnownPoses(const Camera& camera,
                                         const std::vector<StreetPhoto>& photos);

}  // namespace cairn

#endif  // CAIRN_EVAL_STREET_STREET_SCENE_H_
