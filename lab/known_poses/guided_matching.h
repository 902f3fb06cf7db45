// Matches two images whose poses are known: only along epipolar lines.
#ifndef CAIRN_LAB_KNOWN_POSES_GUIDED_MATCHING_H_
#define CAIRN_LAB_KNOWN_POSES_GUIDED_MATCHING_H_

#include <vector>

#include "lab/known_poses/posed_features.h"

namespace cairn {

struct GuidedMatchingOptions {
  double max_epipolar_error_px = 2.0;  // In both images.
  // Best over second best distance. The second best is looked for along the same epipolar line,
  // where the repetitions of a facade lie, farther than 3 px from the best.
  double max_ratio = 0.8;
  // Of the descriptors, relative to their length: with few rivals on its line a match could pass
  // the ratio test without being alike.
  double max_relative_distance = 0.5;
  double min_depth_m = 0.5;  // From either camera.
  double max_depth_m = 150.0;
  double max_size_ratio = 2.0;  // Between the physical sizes of the two keypoints.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

struct FeatureMatch {
  int a_idx = 0;
  int b_idx = 0;
  float distance = 0.0f;  // Euclidean, of the descriptors.
};

// Mutually best matches that pass the ratio test, by a_idx. The planes through both camera centres
// are sorted by their angle about the baseline, so a keypoint meets just the candidates of its own
// epipolar line: O(n log n) and a few dozen descriptor distances a keypoint.
std::vector<FeatureMatch> MatchAlongEpipolarLines(const PosedFeatures& a, const PosedFeatures& b,
                                                  const GuidedMatchingOptions& options);

}  // namespace cairn

#endif  // CAIRN_LAB_KNOWN_POSES_GUIDED_MATCHING_H_
