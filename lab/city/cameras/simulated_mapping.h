// Cars with a panoramic rig drive through the city; a reconstruction comes out, tile by tile.
#ifndef CAIRN_LAB_CITY_CAMERAS_SIMULATED_MAPPING_H_
#define CAIRN_LAB_CITY_CAMERAS_SIMULATED_MAPPING_H_

#include <cstdint>
#include <vector>

#include "core/rigid3.h"
#include "core/tile_id.h"
#include "ingest/sfm/reconstruction.h"
#include "lab/city/cameras/mapping_options.h"
#include "lab/city/geometry/city.h"
#include "lab/city/geometry/smooth_field.h"
#include "lab/descriptors/descriptor_model.h"

namespace cairn {

// One stop of the car.
struct RigKeyframe {
  uint64_t id = 0;
  int pass = 0;
  Eigen::Vector3d center_in_site = Eigen::Vector3d::Zero();  // Of all cameras.
  double heading_rad = 0.0;                                  // Counter-clockwise from east.
};

// What the keyframes in one tile saw. The world of the reconstruction is `site` but for its errors:
// place it by Sim3d ecef_from_site.
struct MappedChunk {
  TileId tile_id;
  Reconstruction reconstruction;  // Empty if no car comes here.
  // Parallel to reconstruction.landmarks: CityLandmark::id. One thing can be several landmarks.
  std::vector<uint64_t> city_landmarks;
  // The truth, parallel to reconstruction.images.
  std::vector<Rigid3d> cam_from_site;
  int num_keyframes = 0;  // Panoramas.
};

// The mapping of one city. Tiles are made one by one, in any order, on any number of threads, with
// the same result. Immutable; safe to use from any thread. `city` and `model` must outlive it.
class SimulatedMapping {
 public:
  // Throws Error(kInvalidArgument) as MappingOptions::Validate.
  SimulatedMapping(const City& city, const DescriptorModel& model, const MappingOptions& options);

  const City& city() const { return city_; }
  const DescriptorModel& model() const { return model_; }
  const MappingOptions& options() const { return options_; }
  Sim3d EcefFromWorld() const;

  // The tiles in which keyframes stand, from the center outwards.
  std::vector<TileId> Tiles() const;

  // Keyframes of a pass in the box; a pure function of the city and the pass.
  std::vector<RigKeyframe> KeyframesIn(const CityBox& box, int pass) const;

  // Only landmarks of min_observations within the tile's own images are in it. Needs memory for
  // one tile: some 600 bytes an observation.
  MappedChunk MapTile(TileId tile_id, int num_threads) const;

  // Observations that MapTile keeps at most, for estimates of memory.
  double ExpectedObservations() const;

 private:
  class ChunkMaker;

  const City& city_;
  const DescriptorModel& model_;
  MappingOptions options_;
  SmoothField deformation_;
  std::vector<SmoothField> drift_;  // By pass.
};

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CAMERAS_SIMULATED_MAPPING_H_
