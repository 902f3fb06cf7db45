// Reconstructs a scene from photos with exactly known poses.
#ifndef CAIRN_CLI_DEMO_STREET_RECONSTRUCT_KNOWN_POSES_H_
#define CAIRN_CLI_DEMO_STREET_RECONSTRUCT_KNOWN_POSES_H_

#include <functional>
#include <vector>

#include "cli/demo/street/street_photo.h"
#include "core/camera.h"
#include "core/features/sift/sift_extractor.h"
#include "core/scene/reconstruction.h"

namespace cairn {

// Fewest observations of a landmark. With two views, a point looks like its repetition.
inline constexpr int kMinKnownPoseObservations = 3;
inline constexpr double kMaxKnownPoseErrorPx = 2.0;  // Of the reprojection of an observation.

struct KnownPoseOptions {
  SiftOptions sift = {.max_features = 1500};
  int num_threads = 2;  // The result does not depend on it.

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// Receives the phase ("features", "matching", "landmarks"), the steps done and the total. Called
// from any thread, but by one thread at a time.
using KnownPoseProgress = std::function<void(const char* phase, int done, int total)>;

// Extracts SIFT features, matches neighboring cameras under their known epipolar geometry, joins
// the matches to tracks and triangulates them. The world frame is enu at the scene's origin.
// Deterministic.
Reconstruction ReconstructWithKnownPoses(const Camera& camera,
                                         const std::vector<StreetPhoto>& photos,
                                         const KnownPoseOptions& options = {},
                                         const KnownPoseProgress& progress = {});

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_STREET_RECONSTRUCT_KNOWN_POSES_H_
