// Joins pairwise matches to tracks. A track lists the observations of one point in many images.
#ifndef CAIRN_CORE_SCENE_TRACKS_H_
#define CAIRN_CORE_SCENE_TRACKS_H_

#include <vector>

#include "core/scene/reconstruction.h"

namespace cairn {

// Two keypoints that may show one point.
struct FeatureMatch {
  int a_idx = 0;
  int b_idx = 0;
  float distance = 0.0f;  // Euclidean distance of the descriptors.
};

struct PairMatches {
  int a_image_idx = 0;
  int b_image_idx = 0;
  std::vector<FeatureMatch> matches;
};

// Joins keypoints by union-find, the most similar descriptors first. Skips a match that would put
// two keypoints of one image into the same track; this splits a wrong track instead of losing it.
// Drops tracks shorter than `min_length`. Observations are in ascending order of images.
// `num_keypoints` has one entry per image.
std::vector<std::vector<ReconObservation>> BuildTracks(const std::vector<PairMatches>& pairs,
                                                       const std::vector<int>& num_keypoints,
                                                       int min_length);

}  // namespace cairn

#endif  // CAIRN_CORE_SCENE_TRACKS_H_
