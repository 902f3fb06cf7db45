// Feature extraction on small images. The first two bytes give the width and the height, the third
// byte the largest number of features. All are small, because a fuzzer needs many inputs and an
// instrumented extraction takes long.
#include <cmath>

#include "core/features/sift/sift_extractor.h"
#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cairn;
  constexpr size_t kHeaderSize = 3;
  constexpr int kMaxSide = 48;
  constexpr int kMaxFeatures = 32;
  if (size < kHeaderSize) {
    return 0;
  }
  GrayImage image = BlankImage(1 + data[0] % kMaxSide, 1 + data[1] % kMaxSide);
  // The bytes repeat, so that short inputs fill large images.
  for (size_t i = 0; i < image.pixels.size() && size > kHeaderSize; ++i) {
    image.pixels[i] = data[kHeaderSize + i % (size - kHeaderSize)];
  }
  const SiftOptions options = {.max_features = 1 + data[2] % kMaxFeatures};
  const FeatureSet features = ExtractSift(image, options);
  const auto num_features = static_cast<int64_t>(features.keypoints.size());
  CAIRN_CHECK(num_features <= options.max_features, "features beyond the limit");
  CAIRN_CHECK(features.descriptors.rows() == num_features, "keypoints without descriptors");
  CAIRN_CHECK(features.descriptors.allFinite(), "a descriptor that is no number");
  CAIRN_CHECK(num_features == 0 || features.descriptors.minCoeff() >= 0.0F, "a negative value");
  CAIRN_CHECK(num_features == 0 || features.descriptors.maxCoeff() <= 255.0F, "a value above 255");
  for (const Keypoint& keypoint : features.keypoints) {
    CAIRN_CHECK(keypoint.x_px >= 0.0F && keypoint.x_px <= static_cast<float>(image.width_px) &&
                    keypoint.y_px >= 0.0F && keypoint.y_px <= static_cast<float>(image.height_px),
                "a keypoint outside of the image");
    CAIRN_CHECK(keypoint.scale_px > 0.0F && std::isfinite(keypoint.orientation_rad),
                "a keypoint without scale or orientation");
  }
  return 0;
}
