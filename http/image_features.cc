#include "http/image_features.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "http/problem.h"
#include "ingest/features/image_header.h"
#include "ingest/features/sift_extractor.h"

namespace cairn {
namespace {

constexpr char kImagePointer[] = "/image";

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void CheckSize(int64_t width_px, int64_t height_px, const Camera& camera, int64_t max_pixels) {
  if (width_px > max_pixels / height_px) {
    throw HttpError(ProblemCode::kImageTooLarge,
                    fmt::format("the image is {} x {} pixels, more than the limit of {}", width_px,
                                height_px, max_pixels))
        .At(kImagePointer)
        .Hint("scale it down, and the camera's parameters with it");
  }
  if (width_px != camera.width_px() || height_px != camera.height_px()) {
    throw HttpError(ProblemCode::kInvalidImage,
                    fmt::format("the image is {} x {} pixels, the camera's images are {} x {}",
                                width_px, height_px, camera.width_px(), camera.height_px()))
        .At("/camera/size")
        .Hint(
            "the camera's parameters refer to the pixels as they are stored, before any rotation "
            "that EXIF asks for");
  }
}

// Raw pixels as the camera's driver has them; nothing if the format or the length is not of that
// kind.
std::optional<GrayImage> FromRawPixels(const LocalizeRequest& request) {
  const Camera& camera = request.query.camera;
  const size_t num_pixels = static_cast<size_t>(camera.width_px()) * camera.height_px();
  GrayImage image{.width_px = camera.width_px(), .height_px = camera.height_px(), .pixels = {}};
  if (request.image_format == "GRAY8" && request.image_bytes.size() == num_pixels) {
    image.pixels = request.image_bytes;
    return image;
  }
  if (request.image_format == "RGBA32" && request.image_bytes.size() == 4 * num_pixels) {
    image.pixels.resize(num_pixels);
    for (size_t i = 0; i < num_pixels; ++i) {
      const uint8_t* rgba = request.image_bytes.data() + 4 * i;
      // ITU-R BT.601 luma in 1/256, as JPEG decoders have it.
      image.pixels[i] =
          static_cast<uint8_t>((77 * rgba[0] + 150 * rgba[1] + 29 * rgba[2] + 128) >> 8);
    }
    return image;
  }
  return std::nullopt;
}

GrayImage Decode(const LocalizeRequest& request, int64_t max_pixels) {
  const Camera& camera = request.query.camera;
  if (std::optional<GrayImage> raw = FromRawPixels(request)) {
    CheckSize(raw->width_px, raw->height_px, camera, max_pixels);
    return std::move(*raw);
  }
  try {
    const ImageHeader header = ParseImageHeader(request.image_bytes);
    CheckSize(header.width_px, header.height_px, camera, max_pixels);
    return DecodeGrayImage(request.image_bytes, {.max_pixels = max_pixels});
  } catch (const HttpError&) {
    throw;
  } catch (const Error& e) {
    throw HttpError(ProblemCode::kInvalidImage, e.what()).At(kImagePointer);
  }
}

}  // namespace

FeatureSet ExtractQueryFeatures(const LocalizeRequest& request, int64_t max_pixels,
                                int max_features, ServerTimes* times) {
  const auto start = std::chrono::steady_clock::now();
  const GrayImage image = Decode(request, max_pixels);
  times->decode_seconds = SecondsSince(start);
  const auto extraction_start = std::chrono::steady_clock::now();
  SiftOptions options;
  options.max_features = std::min(options.max_features, max_features);
  FeatureSet features = ExtractSift(image, options);
  times->extract_seconds = SecondsSince(extraction_start);
  return features;
}

}  // namespace cairn
