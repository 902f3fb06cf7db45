// A part of a scene whose photos are posed relative to each other.
#ifndef CAIRN_MAPPING_SEGMENT_H_
#define CAIRN_MAPPING_SEGMENT_H_

#include <vector>

#include "core/scene/reconstruction.h"

namespace cairn {

struct Segment {
  // Holds only photos of the segment, all with a pose, in the order of the set. Its cameras are all
  // those of the set, with the intrinsics that the adjustment found. Its images have the keypoints
  // of the photos and as many rows of descriptors, but with 0 columns: descriptors stay in the set
  // (PhotoSet). The world frame is arbitrary, its scale too.
  Reconstruction model;
  std::vector<int> photo_of_image;  // Index in PhotoSet::photos, ascending; one for each image.
};

}  // namespace cairn

#endif  // CAIRN_MAPPING_SEGMENT_H_
