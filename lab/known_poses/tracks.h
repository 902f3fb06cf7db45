// Joins pairwise matches to tracks: what one point of the world looks like in many images.
#ifndef CAIRN_LAB_KNOWN_POSES_TRACKS_H_
#define CAIRN_LAB_KNOWN_POSES_TRACKS_H_

#include <vector>

#include "ingest/sfm/reconstruction.h"
#include "lab/known_poses/guided_matching.h"

namespace cairn {

struct PairMatches {
  int a_image_idx = 0;
  int b_image_idx = 0;
  std::vector<FeatureMatch> matches;
};

// Union-find over keypoints, the most alike descriptors first. A match that would put two keypoints
// of one image into a track is left out, which splits a track where it goes wrong instead of losing
// all of it. Tracks shorter than `min_length` are dropped; observations are ascending by image.
// `num_keypoints` has one entry an image.
std::vector<std::vector<ReconObservation>> BuildTracks(const std::vector<PairMatches>& pairs,
                                                       const std::vector<int>& num_keypoints,
                                                       int min_length);

}  // namespace cairn

#endif  // CAIRN_LAB_KNOWN_POSES_TRACKS_H_
