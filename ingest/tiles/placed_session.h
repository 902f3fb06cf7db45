// A reconstruction placed on Earth and freed of landmarks that are not worth keeping; private to
// ingest.
#ifndef CAIRN_INGEST_TILES_PLACED_SESSION_H_
#define CAIRN_INGEST_TILES_PLACED_SESSION_H_

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "core/rigid3.h"
#include "core/scene/reconstruction.h"
#include "core/tile_id.h"

namespace cairn {

// Which landmarks are worth keeping.
struct PlacementOptions {
  int min_observations = 2;
  double max_sigma_m = 2.0;                // Root mean square over the axes of the position.
  double max_reprojection_error_px = 4.0;  // Median over the observations.
};

struct PlacedLandmark {
  uint32_t recon_idx = 0;  // In Reconstruction::landmarks.
  Eigen::Vector3d x_in_ecef;
  double sigma_m = 0.0;           // Root mean square over the axes.
  uint32_t num_observations = 0;  // In all images of the reconstruction.
};

// A keypoint that sees a placed landmark.
struct PlacedObservation {
  uint32_t landmark_idx = 0;  // In PlacedSession::landmarks.
  int keypoint_idx = 0;
};

// The keypoint of each observation.
std::vector<int> KeypointsOf(std::span<const PlacedObservation> observations);

struct PlacedSession {
  std::vector<Rigid3d> cam_from_ecef;     // Per image.
  std::vector<PlacedLandmark> landmarks;  // Neighbors in space are mostly neighbors here.
  std::vector<std::vector<PlacedObservation>> observations_of_image;  // Per image.
  // Images by the tile their camera stands in; only those that see a landmark.
  std::map<TileId, std::vector<int>> images_of_tile;
};

// Fills images_of_tile again after the cameras were moved. Throws as PlaceSession.
void AssignTiles(const Reconstruction& reconstruction, PlacedSession* session);

// Drops landmarks that are seen less often, are less certain or fit worse than the options allow.
// Throws Error(kBadInput) if the similarity or a camera's place makes no sense or if no landmark is
// left. Takes linear time in the observations, apart from one sort.
PlacedSession PlaceSession(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                           const PlacementOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_PLACED_SESSION_H_
