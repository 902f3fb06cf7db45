#include "http/wire/feature_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include "core/camera.h"
#include "core/error.h"
#include "http/wire/problem.h"

namespace cairn {
namespace {

static_assert(std::endian::native == std::endian::little, "the wire is little-endian");

constexpr char kMagic[4] = {'C', 'F', 'T', 'S'};
constexpr uint16_t kVersion = 1;
constexpr size_t kHeaderBytes = 24;
constexpr size_t kMaxCodecLength = 64;
constexpr int kMaxDim = 1024;
constexpr float kOutsideTolerancePx = 1.0f;

constexpr double kPositionSteps = 65535.0;
constexpr double kOrientationStepRad = 2.0 * std::numbers::pi / 256.0;
constexpr double kMinScalePx = 0.25;
constexpr double kScaleStepsPerOctave = 25.5;

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

size_t GeometryBytes(GeometryEncoding encoding) {
  return encoding == GeometryEncoding::kCompact ? sizeof(CompactKeypoint) : sizeof(Keypoint);
}

size_t BytesPerDimension(DescriptorEncoding encoding) {
  switch (encoding) {
    case DescriptorEncoding::kFloat32:
      return 4;
    case DescriptorEncoding::kFloat16:
      return 2;
    default:
      return 1;
  }
}

size_t TableBytes(DescriptorEncoding encoding, size_t dim) {
  return encoding == DescriptorEncoding::kUint8Scaled ? dim * sizeof(ScaledDimension) : 0;
}

[[noreturn]] void Refuse(const std::string& detail) {
  throw HttpError(ProblemCode::kInvalidFeatures, "features: " + detail)
      .At("/features")
      .Hint("the format is docs/formats/features_v1.md");
}

CompactKeypoint Compact(const Keypoint& keypoint, double width_px, double height_px) {
  const auto position = [](double value, double size) {
    return static_cast<uint16_t>(std::lround(std::clamp(value / size, 0.0, 1.0) * kPositionSteps));
  };
  const double turns = keypoint.orientation_rad / kOrientationStepRad;
  const double octaves = std::log2(std::max<double>(keypoint.scale_px, kMinScalePx) / kMinScalePx);
  return {
      .x = position(keypoint.x_px, width_px),
      .y = position(keypoint.y_px, height_px),
      .orientation = static_cast<uint8_t>(std::lround(turns) & 0xff),
      .scale = static_cast<uint8_t>(std::min(255L, std::lround(octaves * kScaleStepsPerOctave)))};
}

Keypoint Expand(const CompactKeypoint& compact, double width_px, double height_px) {
  return {
      .x_px = static_cast<float>(compact.x * width_px / kPositionSteps),
      .y_px = static_cast<float>(compact.y * height_px / kPositionSteps),
      .scale_px = static_cast<float>(kMinScalePx * std::exp2(compact.scale / kScaleStepsPerOctave)),
      .orientation_rad =
          static_cast<float>(WrapAngleRad(compact.orientation * kOrientationStepRad))};
}

bool IsUsable(const Keypoint& keypoint, float width_px, float height_px) {
  const auto inside = [](float value, float size) {
    return value >= -kOutsideTolerancePx && value <= size + kOutsideTolerancePx;
  };
  return inside(keypoint.x_px, width_px) && inside(keypoint.y_px, height_px) &&
         keypoint.scale_px > 0.0f && keypoint.scale_px <= Camera::kMaxSidePx &&
         std::isfinite(keypoint.orientation_rad);
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
                              "scale is not positive",
                              i, wire.width_px, wire.height_px));
    }
  }
}

// Bounds-checked views of the parts of a blob.
struct Layout {
  Header header{};
  std::string codec;
  const uint8_t* table = nullptr;
  const uint8_t* geometry = nullptr;
  const uint8_t* descriptors = nullptr;
};

Header ReadHeader(std::span<const uint8_t> blob, int max_features) {
  Header header;
  if (blob.size() < kHeaderBytes) {
    Refuse(fmt::format("{} bytes are fewer than the {} of the header", blob.size(), kHeaderBytes));
  }
  std::memcpy(&header, blob.data(), kHeaderBytes);
  if (std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0) {
    Refuse("the blob does not start with 'CFTS'");
  }
  if (header.version != kVersion) {
    Refuse(fmt::format("version {} is not supported; this server reads version {}", header.version,
                       kVersion));
  }
  if (header.space > 1) {
    Refuse(fmt::format("unknown descriptor space {}", header.space));
  }
  if (header.descriptor_encoding > 3) {
    Refuse(fmt::format("unknown descriptor encoding {}", header.descriptor_encoding));
  }
  if (header.geometry_encoding > 1) {
    Refuse(fmt::format("unknown geometry encoding {}", header.geometry_encoding));
  }
  if (header.codec_length > kMaxCodecLength) {
    Refuse(fmt::format("the codec name has {} characters; at most {} are allowed",
                       header.codec_length, kMaxCodecLength));
  }
  if (header.dim < 1 || header.dim > kMaxDim) {
    Refuse(fmt::format("dimension {} is outside 1 to {}", header.dim, kMaxDim));
  }
  if (header.width_px < 1 || header.width_px > Camera::kMaxSidePx || header.height_px < 1 ||
      header.height_px > Camera::kMaxSidePx) {
    Refuse(fmt::format("image size {} x {} is outside 1 to 100000", header.width_px,
                       header.height_px));
  }
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
      count * GeometryBytes(static_cast<GeometryEncoding>(header.geometry_encoding));
  const size_t descriptor_bytes = count * header.dim * BytesPerDimension(descriptor_encoding);
  const size_t expected =
      kHeaderBytes + header.codec_length + table_bytes + geometry_bytes + descriptor_bytes;
  if (blob.size() != expected) {
    Refuse(fmt::format("{} features of dimension {} need {} bytes, but the blob has {}", count,
                       header.dim, expected, blob.size()));
  }
  layout.codec.assign(reinterpret_cast<const char*>(blob.data()) + kHeaderBytes,
                      header.codec_length);
  layout.table = blob.data() + kHeaderBytes + header.codec_length;
  layout.geometry = layout.table + table_bytes;
  layout.descriptors = layout.geometry + geometry_bytes;
  const auto printable = [](char c) { return c > ' ' && c <= '~'; };
  if (!std::all_of(layout.codec.begin(), layout.codec.end(), printable)) {
    Refuse("the codec name is not printable ASCII");
  }
  if (header.space == 1 && layout.codec.empty()) {
    Refuse("projected features must name the codec that they were projected for");
  }
  return layout;
}

std::vector<Keypoint> ReadKeypoints(const Layout& layout) {
  const Header& header = layout.header;
  std::vector<Keypoint> keypoints(header.count);
  if (header.geometry_encoding == static_cast<uint8_t>(GeometryEncoding::kCompact)) {
    for (uint32_t i = 0; i < header.count; ++i) {
      CompactKeypoint compact;
      std::memcpy(&compact, layout.geometry + i * sizeof(compact), sizeof(compact));
      keypoints[i] = Expand(compact, header.width_px, header.height_px);
    }
    return keypoints;
  }
  for (uint32_t i = 0; i < header.count; ++i) {
    float values[4];
    std::memcpy(values, layout.geometry + i * sizeof(values), sizeof(values));
    keypoints[i] = {values[0], values[1], values[2], values[3]};
    if (!IsUsable(keypoints[i], static_cast<float>(header.width_px),
                  static_cast<float>(header.height_px))) {
      Refuse(
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
    Refuse("a descriptor is not finite");
  }
  return descriptors;
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
  Header header{.magic = {kMagic[0], kMagic[1], kMagic[2], kMagic[3]},
                .version = kVersion,
                .space = features.space == DescriptorSpace::kProjected,
                .descriptor_encoding = static_cast<uint8_t>(encoding.descriptors),
                .geometry_encoding = static_cast<uint8_t>(encoding.geometry),
                .codec_length = static_cast<uint8_t>(wire.codec.size()),
                .dim = static_cast<uint16_t>(dim),
                .count = static_cast<uint32_t>(features.size()),
                .width_px = static_cast<uint32_t>(wire.width_px),
                .height_px = static_cast<uint32_t>(wire.height_px)};
  const size_t table_bytes = TableBytes(encoding.descriptors, dim);
  Writer writer(kHeaderBytes + wire.codec.size() + table_bytes +
                features.size() * (GeometryBytes(encoding.geometry) +
                                   dim * BytesPerDimension(encoding.descriptors)));
  writer.Append(header);
  writer.Append(wire.codec.data(), wire.codec.size());
  if (table_bytes > 0) {
    writer.Append(MakeTable(features.descriptors).data(), table_bytes);
  }
  for (const Keypoint& keypoint : features.keypoints) {
    if (encoding.geometry == GeometryEncoding::kCompact) {
      writer.Append(Compact(keypoint, wire.width_px, wire.height_px));
    } else {
      writer.Append(
          std::array{keypoint.x_px, keypoint.y_px, keypoint.scale_px, keypoint.orientation_rad});
    }
  }
  AppendDescriptors(features.descriptors, encoding.descriptors, &writer);
  return writer.Take();
}

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
