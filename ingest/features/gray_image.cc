#include "ingest/features/gray_image.h"

#include <fmt/format.h>

#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "core/error.h"
#include "ingest/features/image_header.h"
#include "ingest/readers/file_bytes.h"

namespace cairn {
namespace {

constexpr uint64_t kMaxImageFileBytes = uint64_t{256} << 20;

}  // namespace

GrayImage DecodeGrayImage(std::span<const uint8_t> image_bytes, const ImageDecodeLimits& limits) {
  const ImageHeader header = ParseImageHeader(image_bytes);
  if (header.width_px > limits.max_pixels / header.height_px) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("the image is {} x {} pixels, more than the limit of {}; scale it down",
                            header.width_px, header.height_px, limits.max_pixels));
  }
  if (image_bytes.size() > static_cast<size_t>(std::numeric_limits<int>::max())) {
    throw Error(ErrorCode::kBadInput, "the image file is larger than 2 GiB");
  }
  cv::Mat decoded;
  try {
    const cv::Mat buffer(1, static_cast<int>(image_bytes.size()), CV_8UC1,
                         const_cast<uint8_t*>(image_bytes.data()));
    decoded = cv::imdecode(buffer, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& e) {
    throw Error(ErrorCode::kBadInput, fmt::format("the image does not decode: {}", e.err));
  }
  if (decoded.empty() || decoded.type() != CV_8UC1) {
    throw Error(ErrorCode::kBadInput, "the image does not decode; its file is damaged");
  }
  GrayImage image{.width_px = decoded.cols, .height_px = decoded.rows, .pixels = {}};
  image.pixels.assign(decoded.begin<uint8_t>(), decoded.end<uint8_t>());
  return image;
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
