// SIFT features of an image, by OpenCV.
#ifndef CAIRN_INGEST_FEATURES_SIFT_EXTRACTOR_H_
#define CAIRN_INGEST_FEATURES_SIFT_EXTRACTOR_H_

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/features.h"

namespace cairn {

// An 8-bit grey image, row-major.
struct GrayImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<uint8_t> pixels;  // width * height.
};

struct SiftOptions {
  int max_features = 2000;           // Strongest first.
  double contrast_threshold = 0.02;  // OpenCV's; below its default of 0.04 for dim facades.
  // Images with more pixels are halved until they fit before extraction; keypoints are in pixels of
  // the original image.
  int max_pixels = 3'000'000;

  void Validate() const;
};

struct ImageDecodeLimits {
  int64_t max_pixels = 12'000'000;
};

// Decodes JPEG, PNG and binary PGM/PPM, ignoring EXIF rotation (camera intrinsics refer to the
// stored pixels). Throws Error(kBadInput) if the bytes are none of these, do not decode or are cut
// short, or if the header claims more pixels than the limit (checked before decoding).
GrayImage DecodeGrayImage(std::span<const uint8_t> image_bytes,
                          const ImageDecodeLimits& limits = {});

// Reads and decodes a file; throws Error(kNotFound) or as DecodeGrayImage, naming the path.
GrayImage ReadGrayImage(const std::string& path, const ImageDecodeLimits& limits = {});

// Classic SIFT (descriptor type "sift"): 128-D, not yet root-normalised, as ReadColmap returns them
// too: the same place seen by both gives RootSIFT descriptors 0.08 apart in the median, against 0.5
// and more for different places. Strongest first; the order does not depend on the number of
// threads. Throws Error(kBadInput) if the image's size is not that of its pixels. Thread-safe.
FeatureSet ExtractSift(const GrayImage& image, const SiftOptions& options = {});

}  // namespace cairn

#endif  // CAIRN_INGEST_FEATURES_SIFT_EXTRACTOR_H_
