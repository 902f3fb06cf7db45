// Which way round the pictures of a request are taken.
#ifndef CAIRN_HTTP_JSON_IMAGE_ORIENTATION_H_
#define CAIRN_HTTP_JSON_IMAGE_ORIENTATION_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace cairn {

// A photo file holds pixels as the sensor read them and says in its EXIF how to turn them upright.
// Camera parameters, gravity, matches and pose are all of one of the two pictures.
enum class ImageOrientation {
  kAsSize,   // The picture whose width and height the request states; the stored one if both have.
  kStored,   // The pixels as they are in the file.
  kUpright,  // The picture as EXIF wants it shown.
};

// "stored" and "upright"; a request that names neither means kAsSize.
std::optional<ImageOrientation> ImageOrientationFromName(std::string_view name);
const char* ImageOrientationName(ImageOrientation orientation);  // kAsSize has no name.

// The size and EXIF of an encoded picture, from its header.
struct PictureHeader {
  int width_px = 0, height_px = 0;  // As stored.
  int exif_orientation = 1;
};

// Nothing if the bytes are no JPEG, PNG or PNM; decoding says why.
std::optional<PictureHeader> ReadPictureHeader(std::span<const uint8_t> image_bytes);

// The EXIF orientation to apply so that a picture is the one meant; 1 leaves it as it is stored.
int OrientationToApply(const PictureHeader& header, ImageOrientation meant, int stated_width_px,
                       int stated_height_px);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_IMAGE_ORIENTATION_H_
