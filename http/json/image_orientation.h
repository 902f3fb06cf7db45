// The orientation in which the server takes the pictures of a request.
#ifndef CAIRN_HTTP_JSON_IMAGE_ORIENTATION_H_
#define CAIRN_HTTP_JSON_IMAGE_ORIENTATION_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/camera.h"
#include "core/images/exif.h"

namespace cairn {

// A photo file stores pixels as the sensor read them; its EXIF states how to turn them upright.
// Camera parameters, gravity, matches and pose all refer to one of these two pictures.
enum class ImageOrientation {
  kAsSize,   // The one that has the stated size; the stored picture if both have.
  kStored,   // The pixels as stored in the file.
  kUpright,  // The picture as its EXIF turns it.
};

// The names are "stored" and "upright". A request without a name means kAsSize.
std::optional<ImageOrientation> ImageOrientationFromName(std::string_view name);
const char* ImageOrientationName(ImageOrientation orientation);  // kAsSize has no name.

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
