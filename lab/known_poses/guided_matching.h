// Matches two images with known poses along their epipolar lines.
#ifndef CAIRN_LAB_KNOWN_POSES_GUIDED_MATCHING_H_
#define CAIRN_LAB_KNOWN_POSES_GUIDED_MATCHING_H_

#include <vector>

#include "lab/known_poses/posed_features.h"

namespace cairn {

struct GuidedMatchingOptions {
  double max_epipolar_error_px = 2.0;  // In both images.
  // Largest ratio of the best to the second-best distance. The second best is taken from the same
  // epipolar line, where the repetitions of a facade are, at more than 3 px from the best.
  double max_ratio = 0.8;
  // Largest descriptor distance, relative to the descriptors' length. If a line has few candidates,
  // a match could pass the ratio test without being similar.
  double max_relative_distance = 0.5;
  double min_depth_m = 0.5;  // Distance from either camera.
  double max_depth_m = 150.0;
  double max_size_ratio = 2.0;  // Ratio of the physical sizes of the two keypoints.

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

struct FeatureMatch {
  int a_idx = 0;
  int b_idx = 0;
  float distance = 0.0f;  // Euclidean distance of the descriptors.
};

// Returns the mutually best matches that pass the ratio test, ordered by a_idx. Sorts the planes
// through both camera centers by their angle about the baseline, so that each keypoint is compared
// only with candidates on its own epipolar line. Takes O(n log n) time and a few dozen descriptor
// distances per keypoint.
std::vector<FeatureMatch> MatchAlongEpipolarLines(const PosedFeatures& a, const PosedFeatures& b,
                                                  const GuidedMatchingOptions& options);

}  // namespace cairn

#endif  // CAIRN_LAB_KNOWN_POSES_GUIDED_MATCHING_H_
