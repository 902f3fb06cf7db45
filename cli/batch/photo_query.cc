#include "cli/batch/photo_query.h"

#include <fmt/format.h>

#include <utility>

#include "core/error.h"
#include "core/images/exif.h"
#include "core/images/orient_image.h"
#include "core/images/photo_camera.h"
#include "core/printable.h"
#include "http/json/request_photos.h"

namespace cairn {
namespace {

void SetCamera(const PhotoQueryOptions& options, const ExifInfo& exif, int width_px, int height_px,
               LocalizeQuery* query) {
  if (options.camera) {
    query->camera = *options.camera;
  } else {
    PhotoCamera of_photo = CameraOfPhoto(exif, width_px, height_px);
    query->camera = std::move(of_photo.camera);
    query->focal = of_photo.focal;
  }
  if (options.focal_log_sigma) {
    query->focal = FocalPrior{.log_sigma = *options.focal_log_sigma};
  }
  RequireSizeOf(query->camera, width_px, height_px, query->id);
}

}  // namespace

void RequireSizeOf(const Camera& camera, int width_px, int height_px, const std::string& photo) {
  if (camera.width_px() != width_px || camera.height_px() != height_px) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("{} has {} x {} pixels, but its camera states {} x {}", Printable(photo),
                    width_px, height_px, camera.width_px(), camera.height_px()));
  }
}

PhotoQuery ReadPhotoQuery(const std::string& path, const PhotoQueryOptions& options) {
  PhotoQuery result;
  if (options.with_pixels) {
    result.photo = ReadPhoto(path);
  } else {
    result.photo.bytes = ReadImageBytes(path);
  }
  const ExifInfo exif = ReadExif(result.photo.bytes);
  const int orientation = OrientationForCamera(exif, options.camera ? &*options.camera : nullptr);
  if (options.with_pixels) {
    result.photo.image = OrientImage(std::move(result.photo.image), orientation);
  }
  result.orientation = orientation == 1 ? ImageOrientation::kStored : ImageOrientation::kUpright;
  result.query.id = path;
  const bool swaps = SwapsSides(orientation);
  SetCamera(options, exif, swaps ? exif.height_px : exif.width_px,
            swaps ? exif.width_px : exif.height_px, &result.query);
  result.query.prior = options.prior;
  if (!options.prior && options.exif_prior) {
    result.query.prior = PriorOfPhoto(exif);
  }
  result.query.down_in_cam = options.down_in_cam;
  return result;
}

}  // namespace cairn
