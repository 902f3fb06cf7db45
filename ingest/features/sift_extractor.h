// SIFT features of an image, by OpenCV.
#ifndef CAIRN_INGEST_FEATURES_SIFT_EXTRACTOR_H_
#define CAIRN_INGEST_FEATURES_SIFT_EXTRACTOR_H_

#include "core/features.h"
#include "ingest/features/gray_image.h"

namespace cairn {

struct SiftOptions {
  int max_features = 2000;           // Strongest first.
  double contrast_threshold = 0.02;  // OpenCV's; below its default of 0.04 for dim facades.
  // Images with more pixels are halved until they fit before extraction; keypoints are in pixels of
  // the original image.
  int max_pixels = 3'000'000;

  void Validate() const;
};

// Classic SIFT (descriptor type "sift"): 128-D, not yet root-normalised, as ReadColmap returns them
// too: the same place seen by both gives RootSIFT descriptors 0.08 apart in the median, against 0.5
// and more for different places. Strongest first; the order does not depend on the number of
// threads. Throws Error(kBadInput) if the image's size is not that of its pixels. Thread-safe.
FeatureSet ExtractSift(const GrayImage& image, const SiftOptions& options = {});

}  // namespace cairn

#endif  // CAIRN_INGEST_FEATURES_SIFT_EXTRACTOR_H_
