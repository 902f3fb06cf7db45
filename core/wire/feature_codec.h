// Binary encoding of features on the wire: compact, with an exact length.
// docs/formats/features_v1.md specifies the format.
#ifndef CAIRN_CORE_WIRE_FEATURE_CODEC_H_
#define CAIRN_CORE_WIRE_FEATURE_CODEC_H_

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/features.h"

namespace cairn {

enum class GeometryEncoding : uint8_t {
  kFloat32 = 0,  // 16 bytes a keypoint, exact.
  kCompact = 1,  // 6 bytes: position to 1/65535 of the image, orientation to 1.4 degrees.
};

enum class DescriptorEncoding : uint8_t {
  kFloat32 = 0,
  kFloat16 = 1,
  kUint8 = 2,  // Only for values that are integers in [0, 255].
  kUint8Scaled =
      3,  // One byte a dimension, scaled between the minimum and maximum of the dimension.
};

struct FeatureEncoding {
  GeometryEncoding geometry = GeometryEncoding::kFloat32;
  DescriptorEncoding descriptors = DescriptorEncoding::kFloat32;
};

// Features with the metadata of their blob.
struct WireFeatures {
  FeatureSet features;
  // Projected features: the codec that they were projected for. Raw features: the descriptor type,
  // or empty.
  std::string codec;
  int width_px = 0;  // Size of the image that the features come from.
  int height_px = 0;
};

// Returns the smallest lossless encoding.
FeatureEncoding LosslessEncoding(const FeatureSet& features);

// Throws Error(kBadInput) if the features are invalid, lie outside the image, have more than 1024
// dimensions, or do not fit the encoding (kUint8 with values that are not bytes, float16 overflow).
std::vector<uint8_t> EncodeFeatures(const WireFeatures& features, const FeatureEncoding& encoding);

// Inverse of EncodeFeatures for untrusted bytes; checks everything before it allocates. Throws
// HttpError kInvalidFeatures that describes the fault, or kTooManyFeatures above `max_features`.
WireFeatures DecodeFeatures(std::span<const uint8_t> blob, int max_features);

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_FEATURE_CODEC_H_
