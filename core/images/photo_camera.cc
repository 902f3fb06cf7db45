#include "core/images/photo_camera.h"

#include <algorithm>

namespace cairn {
namespace {

// Some cameras refer to the diagonal of the film instead of its long side, and all round to
// millimeters.
constexpr double kExifFocalLogSigma = 0.05;
// The range of real cameras; EXIF outside this range is damaged.
constexpr double kMinFocal35Mm = 4.0, kMaxFocal35Mm = 2000.0;

}  // namespace

PhotoCamera CameraOfPhoto(const ExifInfo& exif, int width_px, int height_px) {
  const double focal_35mm = exif.focal_35mm.value_or(0.0);
  if (!(focal_35mm >= kMinFocal35Mm && focal_35mm <= kMaxFocal35Mm)) {
    return {CameraOfUnknownFocal(width_px, height_px), FocalPrior{.with_distortion = true}};
  }
  const double focal_px = focal_35mm / kFilmLongSideMm * std::max(width_px, height_px);
  return {Camera(CameraModel::kSimplePinhole, width_px, height_px,
                 {focal_px, 0.5 * width_px, 0.5 * height_px}),
          FocalPrior{.log_sigma = kExifFocalLogSigma}};
}

}  // namespace cairn
