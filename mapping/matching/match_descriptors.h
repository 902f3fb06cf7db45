// Matches the descriptors of two photos by exhaustive comparison.
#ifndef CAIRN_MAPPING_MATCHING_MATCH_DESCRIPTORS_H_
#define CAIRN_MAPPING_MATCHING_MATCH_DESCRIPTORS_H_

#include <span>
#include <vector>

#include "core/features.h"
#include "core/scene/tracks.h"
#include "mapping/photo_set.h"

namespace cairn {

struct DescriptorMatchOptions {
  // Largest ratio of the smallest to the second smallest distance (Lowe 2004).
  double max_ratio = 0.8;
  // Largest distance of RootSIFT descriptors, which are unit vectors. Descriptors of different
  // places differ by 0.5 or more; those of one place, seen from far apart, rarely by more than 0.7.
  double max_distance = 0.7;
};

// What is matched of a photo. `keypoints` may be empty; then each is a place of its own.
struct DescribedPhoto {
  const ByteDescriptorMatrix& descriptors;  // Raw SIFT.
  std::span<const Keypoint> keypoints = {};
};

// Returns the mutually nearest descriptors that pass the ratio test, ordered by a_idx, without
// those that photo a shows twice: what a facade repeats says nothing about where photo b was taken.
// The second smallest distance is that to a keypoint at another place, more than 10 px from the
// nearest (Mishkin, Matas, Perdoch 2015): SIFT describes a corner several times. Compares RootSIFT
// (Arandjelovic and Zisserman 2012) in steps of 1/512, with integers, so the result is the same on
// every processor. `distance` is that of the unit vectors. Takes about 3 ns a pair of descriptors.
std::vector<FeatureMatch> MatchDescriptors(const DescribedPhoto& photo_a,
                                           const DescribedPhoto& photo_b,
                                           const DescriptorMatchOptions& options);

}  // namespace cairn

#endif  // CAIRN_MAPPING_MATCHING_MATCH_DESCRIPTORS_H_
