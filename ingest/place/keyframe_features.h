// A keyframe of a map as a photo: what the tile knows of its features. Private to ingest.
#ifndef CAIRN_INGEST_PLACE_KEYFRAME_FEATURES_H_
#define CAIRN_INGEST_PLACE_KEYFRAME_FEATURES_H_

#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/features.h"
#include "storage/tile/tile.h"

namespace cairn {

struct KeyframeFeatures {
  FeatureSet features;              // In the projected space of the tile's codebook.
  std::vector<uint32_t> landmarks;  // In the tile, parallel to the features.
};

// Returns a feature for each landmark that the keyframe saw: at the pixel to which the landmark
// projects, since maps do not store keypoints, and with the landmark's descriptor whose azimuth is
// nearest to the keyframe's. Scale and orientation are those of this descriptor, seen from the
// keyframe. Landmarks that do not project into the image, or
// have no descriptor, are left out. `descriptors` are the tile's
// codes, decoded.
KeyframeFeatures FeaturesOfKeyframe(const Tile& tile, size_t keyframe_idx, const Camera& camera,
                                    const DescriptorMatrix& descriptors);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_KEYFRAME_FEATURES_H_
