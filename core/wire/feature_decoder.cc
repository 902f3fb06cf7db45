// The half of feature_codec.h that reads.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "core/wire/feature_codec.h"
#include "core/wire/feature_layout.h"
#include "core/wire/problem.h"

namespace cairn {

using namespace feature_layout;

namespace {

[[noreturn]] void RefuseBlob(const std::string& detail) {
  throw HttpError(ProblemCode::kInvalidFeatures, "features: " + detail)
      .At("/features")
      .Hint("the format is docs/formats/features_v1.md");
}

Keypoint Expand(const CompactKeypoint& compact, const GeometryLayout& layout, double width_px,
                double height_px) {
  return {.x_px = static_cast<float>(compact.x * width_px / kPositionSteps),
          .y_px = static_cast<float>(compact.y * height_px / kPositionSteps),
          .scale_px = layout.has_scale
                          ? static_cast<float>(kMinScalePx *
                                               std::exp2(compact.scale / kScaleStepsPerOctave))
                          : kUnknownScalePx,
          .orientation_rad =
              layout.has_orientation
                  ? static_cast<float>(WrapAngleRad(compact.orientation * kOrientationStepRad))
                  : kUnknownOrientationRad};
}

// Bounds-checked views of the parts of a blob.
struct Layout {
  Header header{};
  std::string codec;
  const uint8_t* table = nullptr;
  const uint8_t* geometry = nullptr;
  const uint8_t* descriptors = nullptr;
};

void CheckEncodings(const Header& header) {
  if (header.space > 1) {
    RefuseBlob(fmt::format("unknown descriptor space {}", header.space));
  }
  if (header.descriptor_encoding > 3) {
    RefuseBlob(fmt::format("unknown descriptor encoding {}", header.descriptor_encoding));
  }
  if (header.geometry_encoding > GeometryLayout::kLast) {
    RefuseBlob(fmt::format("unknown geometry encoding {}", header.geometry_encoding));
  }
}

void CheckSizes(const Header& header) {
  if (header.codec_length > kMaxCodecLength) {
    RefuseBlob(fmt::format("the codec name has {} characters; at most {} are allowed",
                           header.codec_length, kMaxCodecLength));
  }
  if (header.dim < 1 || header.dim > kMaxDim) {
    RefuseBlob(fmt::format("dimension {} is outside 1 to {}", header.dim, kMaxDim));
  }
  if (header.width_px < 1 || header.width_px > Camera::kMaxSidePx || header.height_px < 1 ||
      header.height_px > Camera::kMaxSidePx) {
    RefuseBlob(fmt::format("image size {} x {} is outside 1 to 100000", header.width_px,
                           header.height_px));
  }
}

Header ReadHeader(std::span<const uint8_t> blob, int max_features) {
  Header header;
  if (blob.size() < kHeaderBytes) {
    RefuseBlob(
        fmt::format("{} bytes are fewer than the {} of the header", blob.size(), kHeaderBytes));
  }
  std::memcpy(&header, blob.data(), kHeaderBytes);
  if (std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0) {
    RefuseBlob("the blob does not start with 'CFTS'");
  }
  if (header.version != kVersion) {
    RefuseBlob(fmt::format("version {} is not supported; this server reads version {}",
                           header.version, kVersion));
  }
  CheckEncodings(header);
  CheckSizes(header);
  if (header.count > static_cast<uint32_t>(max_features)) {
    throw HttpError(ProblemCode::kTooManyFeatures,
                    fmt::format("{} features exceed the limit of {}", header.count, max_features))
        .At("/features")
        .Hint("send the features with the strongest response");
  }
  return header;
}

Layout ReadLayout(std::span<const uint8_t> blob, int max_features) {
  Layout layout;
  layout.header = ReadHeader(blob, max_features);
  const Header& header = layout.header;
  const auto descriptor_encoding = static_cast<DescriptorEncoding>(header.descriptor_encoding);
  const size_t count = header.count;
  const size_t table_bytes = TableBytes(descriptor_encoding, header.dim);
  const size_t geometry_bytes =
      count * GeometryLayout::FromCode(header.geometry_encoding).NumBytes();
  const size_t descriptor_bytes = count * header.dim * BytesPerDimension(descriptor_encoding);
  const size_t expected =
      kHeaderBytes + header.codec_length + table_bytes + geometry_bytes + descriptor_bytes;
  if (blob.size() != expected) {
    RefuseBlob(fmt::format("{} features of dimension {} need {} bytes, but the blob has {}", count,
                           header.dim, expected, blob.size()));
  }
  layout.codec.assign(reinterpret_cast<const char*>(blob.data()) + kHeaderBytes,
                      header.codec_length);
  layout.table = blob.data() + kHeaderBytes + header.codec_length;
  layout.geometry = layout.table + table_bytes;
  layout.descriptors = layout.geometry + geometry_bytes;
  const auto printable = [](char c) { return c > ' ' && c <= '~'; };
  if (!std::all_of(layout.codec.begin(), layout.codec.end(), printable)) {
    RefuseBlob("the codec name is not printable ASCII");
  }
  if (header.space == 1 && layout.codec.empty()) {
    RefuseBlob("projected features must name the codec that they were projected for");
  }
  return layout;
}

// Copies the bytes of a value and moves on to the next.
template <typename T>
T Take(const uint8_t** bytes) {
  T value;
  std::memcpy(&value, *bytes, sizeof(T));
  *bytes += sizeof(T);
  return value;
}

Keypoint TakeCompact(const GeometryLayout& layout, const Header& header, const uint8_t** bytes) {
  CompactKeypoint compact{};
  compact.x = Take<uint16_t>(bytes);
  compact.y = Take<uint16_t>(bytes);
  if (layout.has_orientation) {
    compact.orientation = Take<uint8_t>(bytes);
  }
  if (layout.has_scale) {
    compact.scale = Take<uint8_t>(bytes);
  }
  return Expand(compact, layout, header.width_px, header.height_px);
}

// A scale that is there must be positive, and an orientation a number.
bool IsWhole(const Keypoint& keypoint, const GeometryLayout& layout) {
  return (!layout.has_scale || HasScale(keypoint)) &&
         (!layout.has_orientation || HasOrientation(keypoint));
}

std::vector<Keypoint> ReadKeypoints(const Layout& layout) {
  const Header& header = layout.header;
  const GeometryLayout geometry = GeometryLayout::FromCode(header.geometry_encoding);
  std::vector<Keypoint> keypoints(header.count);
  const uint8_t* bytes = layout.geometry;
  for (uint32_t i = 0; i < header.count; ++i) {
    Keypoint& keypoint = keypoints[i];
    if (geometry.encoding == GeometryEncoding::kCompact) {
      keypoint = TakeCompact(geometry, header, &bytes);
      continue;
    }
    keypoint.x_px = Take<float>(&bytes);
    keypoint.y_px = Take<float>(&bytes);
    keypoint.scale_px = geometry.has_scale ? Take<float>(&bytes) : kUnknownScalePx;
    keypoint.orientation_rad =
        geometry.has_orientation ? Take<float>(&bytes) : kUnknownOrientationRad;
    if (!IsWhole(keypoint, geometry) || !IsUsable(keypoint, static_cast<float>(header.width_px),
                                                  static_cast<float>(header.height_px))) {
      RefuseBlob(
          fmt::format("keypoint {} lies outside the image, is not finite, "
                      "or its scale is not positive",
                      i));
    }
  }
  return keypoints;
}

void ReadScaled(const Layout& layout, DescriptorMatrix* descriptors) {
  std::vector<ScaledDimension> table(layout.header.dim);
  std::memcpy(table.data(), layout.table, table.size() * sizeof(ScaledDimension));
  const uint8_t* code = layout.descriptors;
  for (Eigen::Index row = 0; row < descriptors->rows(); ++row) {
    for (const ScaledDimension& scaled : table) {
      const Eigen::Index d = &scaled - table.data();
      (*descriptors)(row, d) = scaled.minimum + static_cast<float>(*code++) * scaled.step;
    }
  }
}

DescriptorMatrix ReadDescriptors(const Layout& layout) {
  DescriptorMatrix descriptors(layout.header.count, layout.header.dim);
  const size_t num_values = descriptors.size();
  float* values = descriptors.data();
  switch (static_cast<DescriptorEncoding>(layout.header.descriptor_encoding)) {
    case DescriptorEncoding::kFloat32:
      if (num_values > 0) {
        std::memcpy(values, layout.descriptors, num_values * sizeof(float));
      }
      break;
    case DescriptorEncoding::kFloat16:
      for (size_t i = 0; i < num_values; ++i) {
        uint16_t bits;
        std::memcpy(&bits, layout.descriptors + 2 * i, sizeof(bits));
        values[i] = Eigen::half_impl::half_to_float(Eigen::half_impl::raw_uint16_to_half(bits));
      }
      break;
    case DescriptorEncoding::kUint8:
      std::copy(layout.descriptors, layout.descriptors + num_values, values);
      break;
    case DescriptorEncoding::kUint8Scaled:
      ReadScaled(layout, &descriptors);
      break;
  }
  if (!descriptors.allFinite()) {
    RefuseBlob("a descriptor is not finite");
  }
  return descriptors;
}

}  // namespace

WireFeatures DecodeFeatures(std::span<const uint8_t> blob, int max_features) {
  const Layout layout = ReadLayout(blob, max_features);
  WireFeatures wire;
  wire.codec = layout.codec;
  wire.width_px = static_cast<int>(layout.header.width_px);
  wire.height_px = static_cast<int>(layout.header.height_px);
  wire.features.space =
      layout.header.space == 1 ? DescriptorSpace::kProjected : DescriptorSpace::kRaw;
  wire.features.keypoints = ReadKeypoints(layout);
  wire.features.descriptors = ReadDescriptors(layout);
  return wire;
}

}  // namespace cairn
