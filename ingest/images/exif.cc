#include "ingest/images/exif.h"

#include <algorithm>
#include <cmath>

#include "core/angles.h"
#include "ingest/images/image_header.h"
#include "ingest/images/tiff_directory.h"

namespace cairn {
namespace {

// Tags of the first directory.
constexpr uint16_t kOrientationTag = 0x0112;
constexpr uint16_t kExifDirectoryTag = 0x8769;
constexpr uint16_t kGpsDirectoryTag = 0x8825;
// A tag of the EXIF directory.
constexpr uint16_t kFocalLengthIn35mmTag = 0xa405;
// Tags of the GPS directory.
constexpr uint16_t kLatitudeRefTag = 0x01, kLatitudeTag = 0x02;
constexpr uint16_t kLongitudeRefTag = 0x03, kLongitudeTag = 0x04;
constexpr uint16_t kAltitudeRefTag = 0x05, kAltitudeTag = 0x06;
constexpr uint16_t kPositioningErrorTag = 0x1f;

// Reads degrees, minutes and seconds with a reference letter. Minutes and seconds may be missing.
std::optional<double> AngleRad(const TiffDirectory& gps, uint16_t tag, uint16_t ref_tag,
                               char negative_ref, double max_deg) {
  const std::optional<double> degrees = gps.Number(tag);
  if (!degrees) {
    return std::nullopt;
  }
  const double angle_deg = *degrees + gps.Number(tag, 1).value_or(0.0) / 60.0 +
                           gps.Number(tag, 2).value_or(0.0) / 3600.0;
  if (!(angle_deg >= 0.0 && angle_deg <= max_deg)) {
    return std::nullopt;
  }
  return (gps.Letter(ref_tag) == negative_ref ? -angle_deg : angle_deg) * kRadPerDeg;
}

// Reads the altitude and its reference. GPSAltitudeRef is 0 above and 1 below sea level, 2 above
// and 3 below the ellipsoid.
void ReadAltitude(const TiffDirectory& gps, ExifInfo* info) {
  const std::optional<double> altitude_m = gps.Number(kAltitudeTag);
  if (!altitude_m || std::abs(*altitude_m) > 10'000.0) {
    return;
  }
  const double reference = gps.Number(kAltitudeRefTag).value_or(0.0);
  info->has_altitude = true;
  info->gps->h_m = reference == 1.0 || reference == 3.0 ? -*altitude_m : *altitude_m;
  info->height_reference = reference == 2.0 || reference == 3.0 ? HeightReference::kEllipsoid
                                                                : HeightReference::kMeanSeaLevel;
}

void ReadGps(const TiffDirectory& gps, ExifInfo* info) {
  const auto lat_rad = AngleRad(gps, kLatitudeTag, kLatitudeRefTag, 'S', 90.0);
  const auto lon_rad = AngleRad(gps, kLongitudeTag, kLongitudeRefTag, 'W', 180.0);
  if (!lat_rad || !lon_rad || (*lat_rad == 0.0 && *lon_rad == 0.0)) {
    return;
  }
  info->gps = Geodetic{*lat_rad, *lon_rad, 0.0};
  ReadAltitude(gps, info);
  const std::optional<double> error_m = gps.Number(kPositioningErrorTag);
  if (error_m && *error_m > 0.0) {
    info->gps_error_m = error_m;
  }
}

}  // namespace

ExifInfo ReadExif(std::span<const uint8_t> image_bytes) {
  const ImageHeader header = ParseImageHeader(image_bytes);
  ExifInfo info;
  info.width_px = static_cast<int>(std::min<int64_t>(header.width_px, INT32_MAX));
  info.height_px = static_cast<int>(std::min<int64_t>(header.height_px, INT32_MAX));
  const TiffDirectory first = TiffDirectory::First(header.exif);
  ReadGps(first.Pointed(kGpsDirectoryTag), &info);
  const double orientation = first.Number(kOrientationTag).value_or(1.0);
  info.orientation = orientation >= 1.0 && orientation <= 8.0 ? static_cast<int>(orientation) : 1;
  const std::optional<double> focal_35mm =
      first.Pointed(kExifDirectoryTag).Number(kFocalLengthIn35mmTag);
  if (focal_35mm && *focal_35mm > 0.0) {
    info.focal_35mm = focal_35mm;
  }
  return info;
}

}  // namespace cairn
