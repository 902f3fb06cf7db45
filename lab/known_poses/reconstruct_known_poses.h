// A reconstruction from photos whose poses are known exactly.
#ifndef CAIRN_LAB_KNOWN_POSES_RECONSTRUCT_KNOWN_POSES_H_
#define CAIRN_LAB_KNOWN_POSES_RECONSTRUCT_KNOWN_POSES_H_

#include <functional>
#include <vector>

#include "core/camera.h"
#include "ingest/features/sift_extractor.h"
#include "ingest/sfm/reconstruction.h"
#include "lab/known_poses/guided_matching.h"
#include "lab/known_poses/neighbour_pairs.h"
#include "lab/known_poses/street_photo.h"

namespace cairn {

struct KnownPoseOptions {
  SiftOptions sift = {.max_features = 1500};
  NeighbourOptions neighbours;
  GuidedMatchingOptions matching;
  int min_observations = 3;  // Two views cannot tell a point from its repetition.
  double max_reprojection_error_px = 2.0;
  double min_angle_rad = 0.035;  // Widest angle between two rays of a landmark.
  int num_threads = 2;           // The result does not depend on it.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Phases "features", "matching", "landmarks"; done of total. Called from any thread, one at a time.
using KnownPoseProgress = std::function<void(const char* phase, int done, int total)>;

// Real SIFT of the photos, matched between neighbouring cameras under their known epipolar
// geometry, joined to tracks and triangulated; world is enu at the scene's origin. Deterministic.
Reconstruction ReconstructWithKnownPoses(const Camera& camera,
                                         const std::vector<StreetPhoto>& photos,
                                         const KnownPoseOptions& options = {},
                                         const KnownPoseProgress& progress = {});

}  // namespace cairn

#endif  // CAIRN_LAB_KNOWN_POSES_RECONSTRUCT_KNOWN_POSES_H_
