// SIFT features of an image (Lowe 2004), as the maps have them that COLMAP makes.
#ifndef CAIRN_INGEST_FEATURES_SIFT_EXTRACTOR_H_
#define CAIRN_INGEST_FEATURES_SIFT_EXTRACTOR_H_

#include <cstdint>

#include "core/features.h"
#include "ingest/images/gray_image.h"

namespace cairn {

// One set of defaults for every photo that is localized, through a server or not, and for the demo;
// docs/decisions/0011 has the figures behind them.
struct SiftOptions {
  // Those of the largest scales, as COLMAP keeps them: the strongest are leaves and other fine
  // texture, which no other photo sees again.
  int max_features = 2500;
  // Images with more pixels are reduced to so many before extraction; keypoints are in pixels of
  // the original image.
  int64_t max_pixels = 3'000'000;

  void Validate() const;
};

// Classic SIFT (descriptor type "sift"): 128-D, whole numbers up to 255, not yet root-normalised.
// Keypoints and descriptors are those of COLMAP's (VLFeat's) extractor: RootSIFT descriptors of
// keypoints that both find are 0.07 apart in the median, against 0.5 and more for different places.
//
// The image is searched from its coarsest octave to its own and no further than max_features needs;
// of the last octave the largest keypoints are taken. Only images with few features are searched at
// twice their size, too. The features are in this order. Runs on the calling thread. Results are
// equal for equal processors; they may differ in the last bit between others
// (core/vector_clones.h). Throws Error(kBadInput) if the image's size is not that of its pixels.
// Thread-safe.
FeatureSet ExtractSift(const GrayImage& image, const SiftOptions& options = {});

}  // namespace cairn

#endif  // CAIRN_INGEST_FEATURES_SIFT_EXTRACTOR_H_
