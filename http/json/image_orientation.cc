#include "http/json/image_orientation.h"

#include "core/error.h"
#include "core/images/exif.h"
#include "core/images/orient_image.h"

namespace cairn {

std::optional<PictureHeader> ReadPictureHeader(std::span<const uint8_t> image_bytes) {
  try {
    const ExifInfo exif = ReadExif(image_bytes);
    return PictureHeader{exif.width_px, exif.height_px, exif.orientation};
  } catch (const Error&) {
    return std::nullopt;
  }
}

int OrientationToApply(const PictureHeader& header, ImageOrientation meant, int stated_width_px,
                       int stated_height_px) {
  switch (meant) {
    case ImageOrientation::kStored:
      return 1;
    case ImageOrientation::kUpright:
      return header.exif_orientation;
    case ImageOrientation::kAsSize:
      break;
  }
  const bool is_stored = header.width_px == stated_width_px && header.height_px == stated_height_px;
  const bool is_turned = header.width_px == stated_height_px && header.height_px == stated_width_px;
  return !is_stored && is_turned && SwapsSides(header.exif_orientation) ? header.exif_orientation
                                                                        : 1;
}

int OrientationForCamera(const ExifInfo& exif, const Camera* camera) {
  return camera == nullptr ? exif.orientation
                           : OrientationToApply({exif.width_px, exif.height_px, exif.orientation},
                                                ImageOrientation::kAsSize, camera->width_px(),
                                                camera->height_px());
}

}  // namespace cairn
