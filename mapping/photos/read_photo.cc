#include "mapping/photos/read_photo.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string_view>

#include "core/error.h"
#include "core/features.h"
#include "core/images/gray_image.h"
#include "core/images/image_header.h"
#include "storage/tile/byte_io.h"

namespace cairn {
namespace {

// The formats that people's folders hold and Cairn does not decode, by their first bytes.
std::string FormatReason(std::span<const uint8_t> bytes) {
  const std::string_view start(reinterpret_cast<const char*>(bytes.data()),
                               std::min<size_t>(bytes.size(), 16));
  if (IsVideo(bytes)) {
    return "it is a video; Cairn maps photos";
  }
  if (start.size() >= 12 && start.substr(4, 4) == "ftyp") {
    return "HEIC and AVIF are not supported; convert the photo to JPEG, with its EXIF";
  }
  if (start.starts_with("II*") || start.starts_with("MM")) {
    return "TIFF and raw photos are not supported; convert the photo to JPEG, with its EXIF";
  }
  return "";
}

void PutExif(const ExifInfo& exif, ByteWriter* writer) {
  const auto put = [&](const std::optional<double>& value) {
    writer->Put<uint8_t>(value ? 1 : 0);
    writer->Put<double>(value.value_or(0.0));
  };
  put(exif.gps ? std::optional(exif.gps->lat_rad) : std::nullopt);
  put(exif.gps ? std::optional(exif.gps->lon_rad) : std::nullopt);
  put(exif.gps && exif.has_altitude ? std::optional(exif.gps->h_m) : std::nullopt);
  put(exif.gps_error_m);
  put(exif.focal_35mm);
  put(exif.time_s);
  writer->Put<uint8_t>(exif.height_reference == HeightReference::kEllipsoid ? 1 : 0);
  writer->Put<int32_t>(exif.orientation);
  writer->Put<int32_t>(exif.width_px);
  writer->Put<int32_t>(exif.height_px);
  writer->Put<int32_t>(exif.original_width_px);
  writer->Put<int32_t>(exif.original_height_px);
  writer->Put<uint64_t>(exif.camera_kind);
  writer->Put<uint8_t>(exif.gps_lacks_hemisphere ? 1 : 0);
  writer->Put<uint8_t>(exif.gps_is_void ? 1 : 0);
}

ExifInfo GetExif(ByteReader* reader) {
  const auto get = [&]() -> std::optional<double> {
    const bool has = reader->Get<uint8_t>() != 0;
    const double value = reader->Get<double>();
    return has ? std::optional(value) : std::nullopt;
  };
  ExifInfo exif;
  const auto lat_rad = get(), lon_rad = get(), h_m = get();
  if (lat_rad && lon_rad) {
    exif.gps = Geodetic{*lat_rad, *lon_rad, h_m.value_or(0.0)};
    exif.has_altitude = h_m.has_value();
  }
  exif.gps_error_m = get();
  exif.focal_35mm = get();
  exif.time_s = get();
  exif.height_reference =
      reader->Get<uint8_t>() != 0 ? HeightReference::kEllipsoid : HeightReference::kMeanSeaLevel;
  exif.orientation = reader->Get<int32_t>();
  exif.width_px = reader->Get<int32_t>();
  exif.height_px = reader->Get<int32_t>();
  exif.original_width_px = reader->Get<int32_t>();
  exif.original_height_px = reader->Get<int32_t>();
  exif.camera_kind = reader->Get<uint64_t>();
  exif.gps_lacks_hemisphere = reader->Get<uint8_t>() != 0;
  exif.gps_is_void = reader->Get<uint8_t>() != 0;
  return exif;
}

}  // namespace

ReadPhotoResult ReadMappingPhoto(std::span<const uint8_t> bytes,
                                 const FeatureExtractor& extractor) {
  if (const std::string reason = FormatReason(bytes); !reason.empty()) {
    throw Error(ErrorCode::kBadInput, reason);
  }
  const ImageHeader header = ParseImageHeader(bytes);
  ReadPhotoResult photo;
  photo.exif = ReadExif(bytes);
  photo.has_exif = header.HasExif();
  const GrayImage image = DecodeGrayImage(bytes);
  photo.width_px = image.picture_width_px();
  photo.height_px = image.picture_height_px();
  FeatureSet features = extractor.Extract(image);
  if (features.size() < kMinFeatures) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("only {} features: the photo is blank or blurred", features.size()));
  }
  photo.descriptors = features.descriptors.array().round().cast<uint8_t>();
  photo.keypoints = std::move(features.keypoints);
  return photo;
}

std::vector<uint8_t> EncodeReadPhoto(const ReadPhotoResult& photo) {
  std::vector<uint8_t> bytes;
  ByteWriter writer(&bytes);
  PutExif(photo.exif, &writer);
  writer.Put<uint8_t>(photo.has_exif ? 1 : 0);
  writer.Put<int32_t>(photo.width_px);
  writer.Put<int32_t>(photo.height_px);
  writer.Put<uint32_t>(static_cast<uint32_t>(photo.keypoints.size()));
  for (const Keypoint& keypoint : photo.keypoints) {
    writer.PutArray(std::span<const float>(
        std::array{keypoint.x_px, keypoint.y_px, keypoint.scale_px, keypoint.orientation_rad}));
  }
  writer.PutArray(std::span<const uint8_t>(photo.descriptors.data(),
                                           static_cast<size_t>(photo.descriptors.size())));
  return bytes;
}

ReadPhotoResult DecodeReadPhoto(std::span<const uint8_t> bytes, int descriptor_dim,
                                const std::string& what) {
  ByteReader reader(bytes, what);
  ReadPhotoResult photo;
  photo.exif = GetExif(&reader);
  photo.has_exif = reader.Get<uint8_t>() != 0;
  photo.width_px = reader.Get<int32_t>();
  photo.height_px = reader.Get<int32_t>();
  const size_t count = reader.Get<uint32_t>();
  const std::vector<float> numbers = reader.GetVector<float>(4 * count);
  for (size_t i = 0; i < count; ++i) {
    photo.keypoints.push_back(
        {numbers[4 * i], numbers[4 * i + 1], numbers[4 * i + 2], numbers[4 * i + 3]});
  }
  const std::vector<uint8_t> descriptors =
      reader.GetVector<uint8_t>(static_cast<size_t>(descriptor_dim) * count);
  photo.descriptors = Eigen::Map<const ByteDescriptorMatrix>(
      descriptors.data(), static_cast<Eigen::Index>(count), descriptor_dim);
  if (reader.remaining() > 0 || photo.width_px < 1 || photo.height_px < 1) {
    throw Error(ErrorCode::kMapDamaged, what + ": is no photo of a work folder");
  }
  return photo;
}

}  // namespace cairn
