// Reads place and camera from a photo's EXIF (by exiv2).
#ifndef CAIRN_INGEST_IMAGES_EXIF_H_
#define CAIRN_INGEST_IMAGES_EXIF_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/geodesy.h"
#include "core/geoid.h"

namespace cairn {

struct ExifInfo {
  std::optional<Geodetic> gps;  // Height as in the file.
  bool has_altitude = false;
  // Reference of the height: sea level by default; since EXIF 3, a file may state the ellipsoid.
  HeightReference height_reference = HeightReference::kMeanSeaLevel;
  // The turn or reflection that makes the stored picture upright: 1 (none) to 8.
  int orientation = 1;
  std::optional<double> focal_35mm;  // 35 mm equivalent focal length, millimeters.
  int width_px = 0, height_px = 0;   // 0 if unknown.
};

// Photos without EXIF give an empty ExifInfo. Throws Error(kBadInput) if the bytes are not an
// image.
ExifInfo ReadExif(std::span<const uint8_t> image_bytes);

}  // namespace cairn

#endif  // CAIRN_INGEST_IMAGES_EXIF_H_
