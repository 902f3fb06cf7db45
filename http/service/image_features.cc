#include "http/service/image_features.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "core/check.h"
#include "http/wire/problem.h"
#include "ingest/features/sift_extractor.h"
#include "ingest/images/image_header.h"
#include "ingest/images/orient_image.h"

namespace cairn {
namespace {

// A picture and the camera that took it.
struct Picture {
  const RequestImage& image;
  const Camera& camera;
  std::string pointer;  // "" for the query's own camera, else "/rig/1".
};

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void CheckSize(int64_t width_px, int64_t height_px, const Picture& picture, int64_t max_pixels) {
  const Camera& camera = picture.camera;
  if (width_px > max_pixels / height_px) {
    throw HttpError(ProblemCode::kImageTooLarge,
                    fmt::format("the image has {} x {} pixels, more than the limit of {}", width_px,
                                height_px, max_pixels))
        .At(picture.pointer + "/image")
        .Hint("scale down the image and the camera's parameters");
  }
  if (SwapsSides(picture.image.orientation)) {
    std::swap(width_px, height_px);
  }
  if (width_px != camera.width_px() || height_px != camera.height_px()) {
    throw HttpError(
        ProblemCode::kInvalidImage,
        fmt::format("the image has {} x {} pixels, but the camera's images have {} x {}", width_px,
                    height_px, camera.width_px(), camera.height_px()))
        .At(picture.pointer + "/camera/size")
        .Hint(
            "options.imageOrientation states whether size and parameters describe the picture as "
            "stored or as turned by its EXIF");
  }
}

// Raw pixels from a camera driver. Returns nothing if the format or the length is not that of raw
// pixels.
std::optional<GrayImage> FromRawPixels(const RequestImage& sent, const Camera& camera) {
  const size_t num_pixels = static_cast<size_t>(camera.width_px()) * camera.height_px();
  GrayImage image{.width_px = camera.width_px(), .height_px = camera.height_px(), .pixels = {}};
  if (sent.format == "GRAY8" && sent.bytes.size() == num_pixels) {
    image.pixels = sent.bytes;
    return image;
  }
  if (sent.format == "RGBA32" && sent.bytes.size() == 4 * num_pixels) {
    image.pixels.resize(num_pixels);
    for (size_t i = 0; i < num_pixels; ++i) {
      const uint8_t* rgba = sent.bytes.data() + 4 * i;
      // ITU-R BT.601 luma in units of 1/256, as in JPEG decoders.
      image.pixels[i] =
          static_cast<uint8_t>((77 * rgba[0] + 150 * rgba[1] + 29 * rgba[2] + 128) >> 8);
    }
    return image;
  }
  return std::nullopt;
}

GrayImage Decode(const Picture& picture, const ImageDecodeLimits& limits) {
  const RequestImage& sent = picture.image;
  if (std::optional<GrayImage> raw = FromRawPixels(sent, picture.camera)) {
    CheckSize(raw->width_px, raw->height_px, picture, limits.max_pixels);
    return std::move(*raw);
  }
  try {
    const ImageHeader header = ParseImageHeader(sent.bytes);
    CheckSize(header.width_px, header.height_px, picture, limits.max_pixels);
    return OrientImage(DecodeGrayImage(sent.bytes, limits), sent.orientation);
  } catch (const HttpError&) {
    throw;
  } catch (const DecodingStopped&) {
    throw;
  } catch (const Error& e) {
    throw HttpError(ProblemCode::kInvalidImage, e.what()).At(picture.pointer + "/image");
  }
}

void ThrowIfStopped(const ImageDecodeLimits& limits) {
  if (limits.should_stop && limits.should_stop()) {
    throw DecodingStopped();
  }
}

FeatureSet Extract(const Picture& picture, const ImageDecodeLimits& limits, const SiftOptions& sift,
                   ServerTimes* times) {
  ThrowIfStopped(limits);
  const auto start = std::chrono::steady_clock::now();
  const GrayImage image = Decode(picture, limits);
  times->decode_seconds += SecondsSince(start);
  ThrowIfStopped(limits);
  const auto extraction_start = std::chrono::steady_clock::now();
  FeatureSet features = ExtractSift(image, sift);
  times->extract_seconds += SecondsSince(extraction_start);
  return features;
}

}  // namespace

void ExtractQueryFeatures(const ImageDecodeLimits& limits, const SiftOptions& sift,
                          LocalizeRequest* request, ServerTimes* times) {
  LocalizeQuery& query = request->query;
  const std::vector<RequestImage>& images = request->images;
  CAIRN_CHECK(images.size() == 1 + query.other_cameras.size(), "every camera has an image");
  query.features = Extract({images[0], query.camera, ""}, limits, sift, times);
  for (size_t i = 0; i < query.other_cameras.size(); ++i) {
    RigCamera& other = query.other_cameras[i];
    other.features =
        Extract({images[i + 1], other.camera, fmt::format("/rig/{}", i)}, limits, sift, times);
  }
}

}  // namespace cairn
