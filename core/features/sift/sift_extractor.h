// Extracts SIFT features (Lowe 2004) that match those in maps made by COLMAP.
#ifndef CAIRN_CORE_FEATURES_SIFT_SIFT_EXTRACTOR_H_
#define CAIRN_CORE_FEATURES_SIFT_SIFT_EXTRACTOR_H_

#include <cstdint>
#include <string>

#include "core/features.h"
#include "core/features/feature_extractor.h"
#include "core/images/gray_image.h"
#include "core/stop_function.h"

namespace cairn {

// The same defaults serve every localized photo, with or without a server, and the demo.
// docs/decisions/0011 has the figures behind them.
struct SiftOptions {
  // Keeps the features with the largest scales, as COLMAP does. The strongest features are leaves
  // and other fine texture, which no other photo shows again.
  int max_features = 2500;
  // Larger images are reduced to this number of pixels before extraction.
  int64_t max_pixels = 3'000'000;

  void Validate() const;
};

// Extracts classic SIFT (descriptor type "sift"): 128-D, whole numbers up to 255, without root
// normalization. Keypoints and descriptors match those of COLMAP's extractor (VLFeat). For
// keypoints that both extractors find, the median distance between RootSIFT descriptors is 0.07;
// descriptors of different places differ by 0.5 or more.
//
// The search goes from the coarsest octave to the octave of the image and stops when max_features
// are found. From the last octave it takes the largest keypoints. It searches the doubled image
// only if the image has few features. The features are in the order of the search. Keypoints are in
// pixels of the picture that the image shows (GrayImage::full), at whatever scale it is searched.
//
// Runs on the calling thread. Thread-safe. Results are equal on equal processors; between others
// they may differ in the last bit (core/simd.h). Polls `should_stop`, several times in each octave.
// Once it returns true, returns the features of the octaves that are complete. Throws
// Error(kBadInput) if the image's size does not match the number of its pixels.
FeatureSet ExtractSift(const GrayImage& image, const SiftOptions& options = {},
                       const StopFunction& should_stop = {});

// ExtractSift as a FeatureExtractor.
class SiftExtractor final : public FeatureExtractor {
 public:
  explicit SiftExtractor(const SiftOptions& options = {}) : options_(options) {}

  std::string descriptor_type() const override { return "sift"; }
  int descriptor_dim() const override;
  std::string settings() const override;
  FeatureSet Extract(const GrayImage& image, const StopFunction& should_stop = {}) const override {
    return ExtractSift(image, options_, should_stop);
  }

 private:
  SiftOptions options_;
};

}  // namespace cairn

#endif  // CAIRN_CORE_FEATURES_SIFT_SIFT_EXTRACTOR_H_
