// What a photo's EXIF says about where and with what it was taken (exiv2 behind).
#ifndef CAIRN_INGEST_READERS_EXIF_H_
#define CAIRN_INGEST_READERS_EXIF_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/geodesy.h"

namespace cairn {

struct ExifInfo {
  std::optional<Geodetic> gps;  // Height as written, usually above sea level.
  bool has_altitude = false;
  std::optional<double> focal_35mm;  // 35 mm equivalent focal length, millimetres.
  int width_px = 0, height_px = 0;   // 0 if unknown.
};

// Photos without EXIF give an empty ExifInfo. Throws Error(kBadInput) if the bytes are no image.
ExifInfo ReadExif(std::span<const uint8_t> image_bytes);

}  // namespace cairn

#endif  // CAIRN_INGEST_READERS_EXIF_H_
