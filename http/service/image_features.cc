#include "http/service/image_features.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "core/check.h"
#include "core/images/image_header.h"
#include "core/images/orient_image.h"
#include "core/seconds_since.h"
#include "core/wire/problem.h"

namespace cairn {
namespace {

// A picture and the camera that took it.
struct Picture {
  const RequestImage& image;
  const Camera& camera;
  std::string pointer;  // "" for the query's own camera, else "/rig/1".
};

[[noreturn]] void RefuseTooLarge(const std::string& message, const Picture& picture) {
  throw HttpError(ProblemCode::kImageTooLarge, message)
      .At(picture.pointer + "/image")
      .Hint("the camera's size and parameters scale with the image");
}

// Throws unless the camera's images have this size as stored.
void CheckSize(int64_t width_px, int64_t height_px, const Picture& picture) {
  const Camera& camera = picture.camera;
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

int64_t NumPixels(const Camera& camera) { return int64_t{camera.width_px()} * camera.height_px(); }

// True for pixels from a camera driver: format and length are those of raw pixels.
bool IsRawPixels(const RequestImage& sent, const Camera& camera) {
  const auto num_bytes = static_cast<int64_t>(sent.bytes.size());
  return (sent.format == "GRAY8" && num_bytes == NumPixels(camera)) ||
         (sent.format == "RGBA32" && num_bytes == 4 * NumPixels(camera));
}

GrayImage FromRawPixels(const RequestImage& sent, const Camera& camera) {
  GrayImage image{.width_px = camera.width_px(), .height_px = camera.height_px(), .pixels = {}};
  if (sent.format == "GRAY8") {
    image.pixels = sent.bytes;
    return image;
  }
  image.pixels.resize(static_cast<size_t>(NumPixels(camera)));
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    const uint8_t* rgba = sent.bytes.data() + 4 * i;
    // ITU-R BT.601 luma in units of 1/256, as in JPEG decoders.
    image.pixels[i] =
        static_cast<uint8_t>((77 * rgba[0] + 150 * rgba[1] + 29 * rgba[2] + 128) >> 8);
  }
  return image;
}

GrayImage Decode(const Picture& picture, const ImageDecodeLimits& limits) {
  const RequestImage& sent = picture.image;
  const Camera& camera = picture.camera;
  if (IsRawPixels(sent, camera)) {
    if (camera.width_px() > limits.max_pixels / camera.height_px()) {
      RefuseTooLarge(
          fmt::format("the image has {} x {} pixels, more than the limit of {} for {}; "
                      "send it as JPEG, which may have more, or scale it down",
                      camera.width_px(), camera.height_px(), limits.max_pixels, sent.format),
          picture);
    }
    return FromRawPixels(sent, camera);
  }
  try {
    const ImageHeader header = ParseImageHeader(sent.bytes);
    RequireDecodableSize(header, limits);
    CheckSize(header.width_px, header.height_px, picture);
    return OrientImage(DecodeGrayImage(sent.bytes, limits), sent.orientation);
  } catch (const HttpError&) {
    throw;
  } catch (const DecodingStopped&) {
    throw;
  } catch (const ImageTooLarge& e) {
    RefuseTooLarge(e.what(), picture);
  } catch (const Error& e) {
    throw HttpError(ProblemCode::kInvalidImage, e.what()).At(picture.pointer + "/image");
  }
}

void ThrowIfStopped(const ImageDecodeLimits& limits) {
  if (limits.should_stop && limits.should_stop()) {
    throw DecodingStopped();
  }
}

// Adds the features of the picture and the times of the steps. Throws DecodingStopped.
void AddFeatures(const Picture& picture, const FeatureExtractor& extractor,
                 const ImageDecodeLimits& limits, ImageFeatures* result) {
  ThrowIfStopped(limits);
  const auto start = std::chrono::steady_clock::now();
  const GrayImage image = Decode(picture, limits);
  result->times.decode_seconds += SecondsSince(start);
  ThrowIfStopped(limits);
  const auto extraction_start = std::chrono::steady_clock::now();
  FeatureSet features = extractor.Extract(image, limits.should_stop);
  ThrowIfStopped(limits);
  result->times.extract_seconds += SecondsSince(extraction_start);
  result->of_image.push_back(std::move(features));
}

}  // namespace

ImageFeatures ExtractImageFeatures(const LocalizeRequest& request,
                                   const FeatureExtractor& extractor,
                                   const ImageDecodeLimits& limits) {
  const LocalizeQuery& query = request.query;
  const std::vector<RequestImage>& images = request.images;
  CAIRN_CHECK(images.size() == 1 + query.other_cameras.size(), "every camera has an image");
  ImageFeatures result;
  try {
    AddFeatures({images[0], query.camera, ""}, extractor, limits, &result);
    for (size_t i = 0; i < query.other_cameras.size(); ++i) {
      AddFeatures({images[i + 1], query.other_cameras[i].camera, fmt::format("/rig/{}", i)},
                  extractor, limits, &result);
    }
  } catch (const DecodingStopped&) {
    result.was_stopped = true;
  }
  return result;
}

}  // namespace cairn
