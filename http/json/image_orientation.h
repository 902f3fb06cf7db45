// The orientation in which the server takes the pictures of a request.
#ifndef CAIRN_HTTP_JSON_IMAGE_ORIENTATION_H_
#define CAIRN_HTTP_JSON_IMAGE_ORIENTATION_H_

#include <cstdint>
#include <optional>
#include <span>

#include "core/camera.h"
#include "core/images/exif.h"
#include "core/wire/wire_request.h"

namespace cairn {

// Size and EXIF orientation of an encoded picture, read from its header.
struct PictureHeader {
  int width_px = 0, height_px = 0;  // As stored.
  int exif_orientation = 1;
};

// Returns nothing if the bytes are not JPEG, PNG or PNM. Decoding them reports the reason.
std::optional<PictureHeader> ReadPictureHeader(std::span<const uint8_t> image_bytes);

// The EXIF orientation to apply in order to get the picture that is meant; 1 leaves the stored
// picture unchanged.
int OrientationToApply(const PictureHeader& header, ImageOrientation meant, int stated_width_px,
                       int stated_height_px);

// The same for a picture whose header is read: to the size of the camera, or upright if `camera` is
// null.
int OrientationForCamera(const ExifInfo& exif, const Camera* camera);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_IMAGE_ORIENTATION_H_
