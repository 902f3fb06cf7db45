// The binary layout of features (docs/formats/features_v1.md). Private to the encoder and decoder.
#ifndef CAIRN_CORE_WIRE_FEATURE_LAYOUT_H_
#define CAIRN_CORE_WIRE_FEATURE_LAYOUT_H_

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/angles.h"
#include "core/camera.h"
#include "core/features.h"
#include "core/wire/feature_codec.h"

namespace cairn::feature_layout {

static_assert(std::endian::native == std::endian::little, "the wire is little-endian");

inline constexpr char kMagic[4] = {'C', 'F', 'T', 'S'};
inline constexpr uint16_t kVersion = 1;
inline constexpr size_t kHeaderBytes = 24;
inline constexpr size_t kMaxCodecLength = 64;
inline constexpr int kMaxDim = 1024;
inline constexpr float kOutsideTolerancePx = 1.0f;

inline constexpr double kPositionSteps = 65535.0;
inline constexpr double kOrientationStepRad = 2.0 * kPi / 256.0;
inline constexpr double kMinScalePx = 0.25;
inline constexpr double kScaleStepsPerOctave = 25.5;

struct Header {
  char magic[4];
  uint16_t version;
  uint8_t space;
  uint8_t descriptor_encoding;
  uint8_t geometry_encoding;
  uint8_t codec_length;
  uint16_t dim;
  uint32_t count;
  uint32_t width_px;
  uint32_t height_px;
};
static_assert(sizeof(Header) == kHeaderBytes);

struct CompactKeypoint {
  uint16_t x;
  uint16_t y;
  uint8_t orientation;
  uint8_t scale;
};
static_assert(sizeof(CompactKeypoint) == 6);

struct ScaledDimension {
  float minimum;
  float step;
};

inline size_t GeometryBytes(GeometryEncoding encoding) {
  return encoding == GeometryEncoding::kCompact ? sizeof(CompactKeypoint) : sizeof(Keypoint);
}

inline size_t BytesPerDimension(DescriptorEncoding encoding) {
  switch (encoding) {
    case DescriptorEncoding::kFloat32:
      return 4;
    case DescriptorEncoding::kFloat16:
      return 2;
    default:
      return 1;
  }
}

inline size_t TableBytes(DescriptorEncoding encoding, size_t dim) {
  return encoding == DescriptorEncoding::kUint8Scaled ? dim * sizeof(ScaledDimension) : 0;
}

// True if the keypoint lies in the image or near its border and has a positive scale.
inline bool IsUsable(const Keypoint& keypoint, float width_px, float height_px) {
  const auto inside = [](float value, float size) {
    return value >= -kOutsideTolerancePx && value <= size + kOutsideTolerancePx;
  };
  return inside(keypoint.x_px, width_px) && inside(keypoint.y_px, height_px) &&
         keypoint.scale_px > 0.0f && keypoint.scale_px <= Camera::kMaxSidePx &&
         std::isfinite(keypoint.orientation_rad);
}

}  // namespace cairn::feature_layout

#endif  // CAIRN_CORE_WIRE_FEATURE_LAYOUT_H_
