// Features on the wire: binary, compact, exact length. The format is docs/formats/features_v1.md.
#ifndef CAIRN_HTTP_WIRE_FEATURE_CODEC_H_
#define CAIRN_HTTP_WIRE_FEATURE_CODEC_H_

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
  kUint8 = 2,        // Values that are integers in [0, 255] already.
  kUint8Scaled = 3,  // One byte a dimension between the dimension's minimum and maximum.
};

struct FeatureEncoding {
  GeometryEncoding geometry = GeometryEncoding::kFloat32;
  DescriptorEncoding descriptors = DescriptorEncoding::kFloat32;
};

// Features with what the blob says about them.
struct WireFeatures {
  FeatureSet features;
  // Projected space: the codec they were projected for. Raw: the descriptor type, or empty.
  std::string codec;
  int width_px = 0;  // Of the image they came from.
  int height_px = 0;
};

// The smallest encoding that loses nothing.
FeatureEncoding LosslessEncoding(const FeatureSet& features);

// Throws Error(kBadInput) if the features are not valid, do not lie in the image, are of more than
// 1024 dimensions, or do not fit the encoding (kUint8 with other than bytes, float16 overflow).
std::vector<uint8_t> EncodeFeatures(const WireFeatures& features, const FeatureEncoding& encoding);

// Inverse of EncodeFeatures, for untrusted bytes: checks everything before it allocates. Throws
// HttpError kInvalidFeatures that says what is wrong, kTooManyFeatures above `max_features`.
WireFeatures DecodeFeatures(std::span<const uint8_t> blob, int max_features);

}  // namespace cairn

#endif  // CAIRN_HTTP_WIRE_FEATURE_CODEC_H_
