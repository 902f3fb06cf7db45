#include "core/images/gray_image.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/images/image_header.h"
#include "core/images/jpeg_decoder.h"
#include "core/images/png_decoder.h"
#include "core/images/pnm_decoder.h"

namespace cairn {
namespace {

constexpr uint64_t kMaxImageFileBytes = uint64_t{256} << 20;

}  // namespace

GrayImage BlankImage(int64_t width_px, int64_t height_px) {
  GrayImage image{.width_px = static_cast<int>(width_px),
                  .height_px = static_cast<int>(height_px),
                  .pixels = {}};
  image.pixels.resize(static_cast<size_t>(width_px) * static_cast<size_t>(height_px));
  return image;
}

void RequireDecodableSize(const ImageHeader& header, const ImageDecodeLimits& limits) {
  const bool is_jpeg = header.format == ImageFormat::kJpeg;
  const int64_t max_pixels =
      is_jpeg ? limits.max_pixels * ImageDecodeLimits::kMaxJpegReduction : limits.max_pixels;
  if (header.width_px > max_pixels / header.height_px) {
    throw ImageTooLarge(fmt::format(
        "the image has {} x {} pixels, more than the limit of {} for {}; {}", header.width_px,
        header.height_px, max_pixels, ImageFormatName(header.format),
        is_jpeg ? "scale it down" : "save it as JPEG, which may have more, or scale it down"));
  }
}

GrayImage DecodeGrayImage(std::span<const uint8_t> image_bytes, const ImageDecodeLimits& limits) {
  const ImageHeader header = ParseImageHeader(image_bytes);
  RequireDecodableSize(header, limits);
  if (header.is_panorama) {
    throw Error(
        ErrorCode::kBadInput,
        "the image is a panorama, by its XMP (GPano:ProjectionType): it has no camera; send "
        "a plain photo");
  }
  switch (header.format) {
    case ImageFormat::kJpeg:
      return DecodeJpeg(image_bytes, header, limits);
    case ImageFormat::kPng:
      return DecodePng(image_bytes, header, limits);
    case ImageFormat::kPnm:
      break;
  }
  return DecodePnm(image_bytes, limits);
}

std::vector<uint8_t> ReadImageBytes(const std::string& path) {
  return ReadFileBytes(path, kMaxImageFileBytes);
}

Photo ReadPhoto(const std::string& path, const ImageDecodeLimits& limits) {
  Photo photo{.bytes = ReadImageBytes(path), .image = {}};
  try {
    photo.image = DecodeGrayImage(photo.bytes, limits);
  } catch (const Error& e) {
    throw Error(e.code(), fmt::format("{}: {}", path, e.what()));
  }
  return photo;
}

GrayImage ReadGrayImage(const std::string& path, const ImageDecodeLimits& limits) {
  return ReadPhoto(path, limits).image;
}

}  // namespace cairn
