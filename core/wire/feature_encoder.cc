// The half of feature_codec.h that writes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "core/error.h"
#include "core/wire/feature_codec.h"
#include "core/wire/feature_layout.h"

namespace cairn {

using namespace feature_layout;

namespace {

CompactKeypoint Compact(const Keypoint& keypoint, double width_px, double height_px) {
  const double orientation_rad = HasOrientation(keypoint) ? keypoint.orientation_rad : 0.0;
  const auto position = [](double value, double size) {
    return static_cast<uint16_t>(std::lround(std::clamp(value / size, 0.0, 1.0) * kPositionSteps));
  };
  const double turns = orientation_rad / kOrientationStepRad;
  const double octaves = std::log2(std::max<double>(keypoint.scale_px, kMinScalePx) / kMinScalePx);
  return {
      .x = position(keypoint.x_px, width_px),
      .y = position(keypoint.y_px, height_px),
      .orientation = static_cast<uint8_t>(std::lround(turns) & 0xff),
      .scale = static_cast<uint8_t>(std::min(255L, std::lround(octaves * kScaleStepsPerOctave)))};
}

bool IsByte(float value) { return value >= 0.0f && value <= 255.0f && value == std::floor(value); }

// Appends plain values to a byte vector.
class Writer {
 public:
  explicit Writer(size_t num_bytes) { bytes_.reserve(num_bytes); }

  void Append(const void* data, size_t size) {
    const auto* begin = static_cast<const uint8_t*>(data);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }
  template <typename T>
  void Append(const T& value) {
    Append(&value, sizeof(T));
  }
  std::vector<uint8_t> Take() { return std::move(bytes_); }

 private:
  std::vector<uint8_t> bytes_;
};

std::vector<ScaledDimension> MakeTable(const DescriptorMatrix& descriptors) {
  std::vector<ScaledDimension> table(descriptors.cols(), {0.0f, 0.0f});
  for (Eigen::Index d = 0; d < descriptors.cols() && descriptors.rows() > 0; ++d) {
    const float minimum = descriptors.col(d).minCoeff();
    table[d] = {minimum, (descriptors.col(d).maxCoeff() - minimum) / 255.0f};
  }
  return table;
}

void AppendScaled(const DescriptorMatrix& descriptors, const std::vector<ScaledDimension>& table,
                  Writer* writer) {
  for (Eigen::Index row = 0; row < descriptors.rows(); ++row) {
    for (Eigen::Index d = 0; d < descriptors.cols(); ++d) {
      const ScaledDimension& scaled = table[d];
      const float steps =
          scaled.step > 0.0f ? (descriptors(row, d) - scaled.minimum) / scaled.step : 0.0f;
      writer->Append(static_cast<uint8_t>(std::clamp(std::lround(steps), 0L, 255L)));
    }
  }
}

void AppendDescriptors(const DescriptorMatrix& descriptors, DescriptorEncoding encoding,
                       Writer* writer) {
  const std::span<const float> values(descriptors.data(), descriptors.size());
  switch (encoding) {
    case DescriptorEncoding::kFloat32:
      writer->Append(values.data(), values.size_bytes());
      return;
    case DescriptorEncoding::kFloat16:
      for (const float value : values) {
        const Eigen::half half(value);
        if (!Eigen::numext::isfinite(half)) {
          throw Error(ErrorCode::kBadInput,
                      fmt::format("descriptor value {} does not fit a half float", value));
        }
        writer->Append(half.x);
      }
      return;
    case DescriptorEncoding::kUint8:
      for (const float value : values) {
        if (!IsByte(value)) {
          throw Error(ErrorCode::kBadInput,
                      fmt::format("descriptor value {} is not an integer in [0, 255]", value));
        }
        writer->Append(static_cast<uint8_t>(value));
      }
      return;
    case DescriptorEncoding::kUint8Scaled:
      AppendScaled(descriptors, MakeTable(descriptors), writer);
      return;
  }
}

void CheckEncodable(const WireFeatures& wire) {
  ValidateFeatures(wire.features, "features");
  const Eigen::Index dim = wire.features.descriptors.cols();
  if (dim < 1 || dim > kMaxDim || wire.codec.size() > kMaxCodecLength || wire.width_px < 1 ||
      wire.height_px < 1) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("features cannot be encoded: dimension {} (1 to {}), codec '{}' (at "
                    "most {} characters), image {} x {}",
                    dim, kMaxDim, wire.codec, kMaxCodecLength, wire.width_px, wire.height_px));
  }
  for (int i = 0; i < wire.features.size(); ++i) {
    if (!IsUsable(wire.features.keypoints[i], wire.width_px, wire.height_px)) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("keypoint {} lies outside the image of {} x {} pixels or its "
                              "scale is out of range",
                              i, wire.width_px, wire.height_px));
    }
  }
}

// A blob has the scales of all keypoints or of none, and so with orientations.
bool AllOrNone(const std::vector<Keypoint>& keypoints, bool (*has)(const Keypoint&),
               const char* what) {
  const auto count = std::count_if(keypoints.begin(), keypoints.end(), has);
  if (count != 0 && count != std::ssize(keypoints)) {
    throw Error(ErrorCode::kBadInput, fmt::format("{} of {} keypoints have {}; a request has "
                                                  "those of all keypoints or of none",
                                                  count, keypoints.size(), what));
  }
  return count > 0 || keypoints.empty();
}

void AppendKeypoint(const Keypoint& keypoint, const GeometryLayout& layout,
                    const WireFeatures& wire, Writer* writer) {
  if (layout.encoding == GeometryEncoding::kCompact) {
    const CompactKeypoint compact = Compact(keypoint, wire.width_px, wire.height_px);
    writer->Append(compact.x);
    writer->Append(compact.y);
    if (layout.has_orientation) {
      writer->Append(compact.orientation);
    }
    if (layout.has_scale) {
      writer->Append(compact.scale);
    }
    return;
  }
  writer->Append(keypoint.x_px);
  writer->Append(keypoint.y_px);
  if (layout.has_scale) {
    writer->Append(keypoint.scale_px);
  }
  if (layout.has_orientation) {
    writer->Append(keypoint.orientation_rad);
  }
}

}  // namespace

FeatureEncoding LosslessEncoding(const FeatureSet& features) {
  const float* begin = features.descriptors.data();
  const bool bytes = std::all_of(begin, begin + features.descriptors.size(), IsByte);
  return {.geometry = GeometryEncoding::kFloat32,
          .descriptors = bytes ? DescriptorEncoding::kUint8 : DescriptorEncoding::kFloat32};
}

std::vector<uint8_t> EncodeFeatures(const WireFeatures& wire, const FeatureEncoding& encoding) {
  CheckEncodable(wire);
  const FeatureSet& features = wire.features;
  const size_t dim = features.descriptors.cols();
  const GeometryLayout geometry = {encoding.geometry,
                                   AllOrNone(features.keypoints, HasScale, "scales"),
                                   AllOrNone(features.keypoints, HasOrientation, "orientations")};
  Header header{.magic = {kMagic[0], kMagic[1], kMagic[2], kMagic[3]},
                .version = kVersion,
                .space = features.space == DescriptorSpace::kProjected,
                .descriptor_encoding = static_cast<uint8_t>(encoding.descriptors),
                .geometry_encoding = geometry.Code(),
                .codec_length = static_cast<uint8_t>(wire.codec.size()),
                .dim = static_cast<uint16_t>(dim),
                .count = static_cast<uint32_t>(features.size()),
                .width_px = static_cast<uint32_t>(wire.width_px),
                .height_px = static_cast<uint32_t>(wire.height_px)};
  const size_t table_bytes = TableBytes(encoding.descriptors, dim);
  Writer writer(kHeaderBytes + wire.codec.size() + table_bytes +
                features.size() *
                    (geometry.NumBytes() + dim * BytesPerDimension(encoding.descriptors)));
  writer.Append(header);
  writer.Append(wire.codec.data(), wire.codec.size());
  if (table_bytes > 0) {
    writer.Append(MakeTable(features.descriptors).data(), table_bytes);
  }
  for (const Keypoint& keypoint : features.keypoints) {
    AppendKeypoint(keypoint, geometry, wire, &writer);
  }
  AppendDescriptors(features.descriptors, encoding.descriptors, &writer);
  return writer.Take();
}

}  // namespace cairn
