// Simulates cars that drive a panoramic rig through the city. The result is a reconstruction, tile
// by tile.
#ifndef CAIRN_LAB_CITY_SIMULATED_MAPPING_H_
#define CAIRN_LAB_CITY_SIMULATED_MAPPING_H_

#include <cstdint>
#include <vector>

#include "core/rigid3.h"
#include "core/scene/reconstruction.h"
#include "core/tile_id.h"
#include "lab/city/city.h"
#include "lab/city/mapping_options.h"
#include "lab/city/smooth_field.h"
#include "lab/descriptors/descriptor_model.h"

namespace cairn {

// One stop of the car.
struct RigKeyframe {
  uint64_t id = 0;
  int pass = 0;
  Eigen::Vector3d center_in_site = Eigen::Vector3d::Zero();  // Center of all cameras.
  double heading_rad = 0.0;                                  // Counterclockwise from east.
};

// The reconstruction from the keyframes in one tile. Its world frame is `site`, apart from the
// mapping errors: place the reconstruction with Sim3d ecef_from_site.
struct MappedChunk {
  TileId tile_id;
  Reconstruction reconstruction;  // Empty if no car drives here.
  // Parallel to reconstruction.landmarks: CityLandmark::id. One physical point can have several
  // landmarks.
  std::vector<uint64_t> city_landmarks;
  // Parallel to it: what looks the same at the same place. A window that replaces an equal window
  // is another landmark of the city and the same thing here.
  std::vector<uint64_t> things;
  // Parallel to it: the thing, and the direction and scale from which the landmark is seen, as
  // coarsely as matching can connect (SimulatedMappingOptions::track_view_rad, track_octaves).
  std::vector<uint64_t> views;
  // True poses, parallel to reconstruction.images.
  std::vector<Rigid3d> cam_from_site;
  int num_keyframes = 0;  // Number of panoramas.
};

// The mapping of one city. Tiles can be made one by one in any order and on any number of threads,
// with the same result. Immutable; safe to use from any thread. `city` and `model` must outlive the
// object.
class SimulatedMapping {
 public:
  // Throws the Error(kInvalidArgument) of SimulatedMappingOptions::Validate.
  SimulatedMapping(const City& city, const DescriptorModel& model,
                   const SimulatedMappingOptions& options);

  const City& city() const { return city_; }
  const DescriptorModel& model() const { return model_; }
  const SimulatedMappingOptions& options() const { return options_; }
  Sim3d EcefFromWorld() const;

  // The tiles that contain keyframes, from the center outward.
  std::vector<TileId> Tiles() const;

  // Returns the keyframes of a pass in the box. A pure function of the city and the pass.
  std::vector<RigKeyframe> KeyframesIn(const CityBox& box, int pass) const;

  // Maps one tile. A landmark needs min_observations within the tile's own images. Needs memory for
  // one tile: about 600 bytes per observation.
  MappedChunk MapTile(TileId tile_id, int num_threads) const;
  // The same for one pass alone, as a session of its own sees the tile.
  MappedChunk MapTileInPass(TileId tile_id, int pass, int num_threads) const;

  // Upper bound on the observations that MapTile keeps, for estimates of memory.
  double ExpectedObservations() const;

 private:
  class ChunkMaker;

  const City& city_;
  const DescriptorModel& model_;
  SimulatedMappingOptions options_;
  SmoothField deformation_;
  std::vector<SmoothField> drift_;  // One per pass.
};

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_SIMULATED_MAPPING_H_
