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
#include "core/keypoint_shape.h"
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

// The byte `geometry encoding` of a header: a GeometryEncoding, and what the records leave out.
struct GeometryLayout {
  static constexpr uint8_t kWithoutScale = 2;
  static constexpr uint8_t kWithoutOrientation = 4;
  static constexpr uint8_t kLast = 7;

  GeometryEncoding encoding = GeometryEncoding::kFloat32;
  bool has_scale = true;
  bool has_orientation = true;

  static GeometryLayout FromCode(uint8_t code) {
    return {static_cast<GeometryEncoding>(code & 1), (code & kWithoutScale) == 0,
            (code & kWithoutOrientation) == 0};
  }
  uint8_t Code() const {
    return static_cast<uint8_t>(static_cast<uint8_t>(encoding) | (has_scale ? 0 : kWithoutScale) |
                                (has_orientation ? 0 : kWithoutOrientation));
  }
  size_t NumBytes() const {
    const size_t num_optional = (has_scale ? 1 : 0) + (has_orientation ? 1 : 0);
    return encoding == GeometryEncoding::kCompact ? 2 * sizeof(uint16_t) + num_optional
                                                  : (2 + num_optional) * sizeof(float);
  }
};

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

// True if the keypoint lies in the image or near its border, and its scale and orientation are
// unknown or in range.
inline bool IsUsable(const Keypoint& keypoint, float width_px, float height_px) {
  const auto inside = [](float value, float size) {
    return value >= -kOutsideTolerancePx && value <= size + kOutsideTolerancePx;
  };
  return inside(keypoint.x_px, width_px) && inside(keypoint.y_px, height_px) &&
         keypoint.scale_px >= 0.0f && keypoint.scale_px <= Camera::kMaxSidePx &&
         !std::isinf(keypoint.orientation_rad);
}

}  // namespace cairn::feature_layout

#endif  // CAIRN_CORE_WIRE_FEATURE_LAYOUT_H_
