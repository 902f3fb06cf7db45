// Reads place and camera from a photo's EXIF.
#ifndef CAIRN_CORE_IMAGES_EXIF_H_
#define CAIRN_CORE_IMAGES_EXIF_H_

#include <cstdint>
#include <optional>
#include <span>

#include "core/geodesy.h"
#include "core/geoid.h"

namespace cairn {

// The long side of a frame of 35 mm film, to which EXIF's equivalent focal length refers.
inline constexpr double kFilmLongSideMm = 36.0;

struct ExifInfo {
  // Height as in the file. Latitude and longitude 0 are those of a receiver without a fix; they
  // count as no position. If the EXIF has no position, that of the XMP of a JPEG.
  std::optional<Geodetic> gps;
  // The file does not say north or south, or east or west: north and east are assumed.
  bool gps_lacks_hemisphere = false;
  // The receiver marked its position as void (GPSStatus V): `gps` is empty.
  bool gps_is_void = false;
  bool has_altitude = false;
  // Reference of the height: sea level by default; since EXIF 3, a file may state the ellipsoid.
  HeightReference height_reference = HeightReference::kMeanSeaLevel;
  // Horizontal error of the position, meters (GPSHPositioningError, iPhones among others);
  // positive.
  std::optional<double> gps_error_m;
  // The turn or reflection that makes the stored picture upright: 1 (none) to 8.
  int orientation = 1;
  std::optional<double> focal_35mm;  // 35 mm equivalent, as stated or by the sensor; millimeters.
  int width_px = 0, height_px = 0;   // Of the stored picture.
  // The size that the camera gave the picture (PixelXDimension); 0 if not stated. Of a picture that
  // was cropped later, another one than that of the stored picture.
  int original_width_px = 0, original_height_px = 0;
  // A hash of make, model and focal length: the same for cameras of a kind at one zoom. 0: none.
  uint64_t camera_kind = 0;
  // When the photo was taken (DateTimeOriginal), in seconds since 1970 by the clock of the camera,
  // whose time zone is not known.
  std::optional<double> time_s;
};

// Photos without EXIF, and photos whose EXIF is damaged, give the values that can be read. Takes
// time linear in the length of the photo's header and of its EXIF, of which at most the first
// TiffDirectory::kMaxBytes are read. Allocates nothing, but for EXIF that a PNG has as text only
// (raw_profile.h). Throws Error(kBadInput) if the bytes are not an image.
ExifInfo ReadExif(std::span<const uint8_t> image_bytes);

}  // namespace cairn

#endif  // CAIRN_CORE_IMAGES_EXIF_H_
