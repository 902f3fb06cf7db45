// What a photo's EXIF says about where and with what it was taken (exiv2 behind).
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
  std::optional<Geodetic> gps;  // Height as written.
  bool has_altitude = false;
  // Of the height: EXIF means sea level unless it says, since its version 3, the ellipsoid.
  HeightReference height_reference = HeightReference::kMeanSeaLevel;
  // How the stored picture is to be turned or mirrored to be upright: 1 (not at all) to 8.
  int orientation = 1;
  std::optional<double> focal_35mm;  // 35 mm equivalent focal length, millimetres.
  int width_px = 0, height_px = 0;   // 0 if unknown.
};

// Photos without EXIF give an empty ExifInfo. Throws Error(kBadInput) if the bytes are no image.
ExifInfo ReadExif(std::span<const uint8_t> image_bytes);

}  // namespace cairn

#endif  // CAIRN_INGEST_IMAGES_EXIF_H_
