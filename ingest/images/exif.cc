#include "ingest/images/exif.h"

#include <algorithm>
#include <cmath>
#include <exiv2/error.hpp>
#include <exiv2/exif.hpp>

#include "core/angles.h"
#include "core/error.h"
#include "ingest/images/image_header.h"

namespace cairn {
namespace {

// The `n`-th rational of a tag. Returns nothing if the tag or the number is missing or not finite.
std::optional<double> Number(const Exiv2::ExifData& exif, const char* key, long n = 0) {
  const auto tag = exif.findKey(Exiv2::ExifKey(key));
  if (tag == exif.end() || tag->count() <= n) {
    return std::nullopt;
  }
  const Exiv2::Rational rational = tag->toRational(n);
  if (rational.second == 0) {
    return std::nullopt;
  }
  return static_cast<double>(rational.first) / rational.second;
}

// Reads degrees, minutes and seconds with a reference letter. Minutes and seconds may be missing.
std::optional<double> AngleRad(const Exiv2::ExifData& exif, const char* key, const char* ref_key,
                               char negative_ref, double max_deg) {
  const std::optional<double> degrees = Number(exif, key);
  if (!degrees) {
    return std::nullopt;
  }
  const double angle_deg = *degrees + Number(exif, key, 1).value_or(0.0) / 60.0 +
                           Number(exif, key, 2).value_or(0.0) / 3600.0;
  if (!(angle_deg >= 0.0 && angle_deg <= max_deg)) {
    return std::nullopt;
  }
  const auto ref = exif.findKey(Exiv2::ExifKey(ref_key));
  const std::string letter = ref == exif.end() ? "" : ref->toString();
  const bool negative = !letter.empty() && letter[0] == negative_ref;
  return (negative ? -angle_deg : angle_deg) * kRadPerDeg;
}

// The whole number of a tag, or `fallback` if there is none.
long WholeNumber(const Exiv2::ExifData& exif, const char* key, long fallback) {
  const auto tag = exif.findKey(Exiv2::ExifKey(key));
  return tag != exif.end() && tag->count() > 0 ? tag->toLong() : fallback;
}

// Reads the altitude and its reference. GPSAltitudeRef is 0 above and 1 below sea level, 2 above
// and 3 below the ellipsoid.
void ReadAltitude(const Exiv2::ExifData& exif, ExifInfo* info) {
  const std::optional<double> altitude_m = Number(exif, "Exif.GPSInfo.GPSAltitude");
  if (!altitude_m || std::abs(*altitude_m) > 10'000.0) {
    return;
  }
  const long reference = WholeNumber(exif, "Exif.GPSInfo.GPSAltitudeRef", 0);
  info->has_altitude = true;
  info->gps->h_m = reference == 1 || reference == 3 ? -*altitude_m : *altitude_m;
  info->height_reference = reference == 2 || reference == 3 ? HeightReference::kEllipsoid
                                                            : HeightReference::kMeanSeaLevel;
}

void ReadTags(const Exiv2::ExifData& exif, ExifInfo* info) {
  const auto lat_rad =
      AngleRad(exif, "Exif.GPSInfo.GPSLatitude", "Exif.GPSInfo.GPSLatitudeRef", 'S', 90.0);
  const auto lon_rad =
      AngleRad(exif, "Exif.GPSInfo.GPSLongitude", "Exif.GPSInfo.GPSLongitudeRef", 'W', 180.0);
  if (lat_rad && lon_rad) {
    info->gps = Geodetic{*lat_rad, *lon_rad, 0.0};
    ReadAltitude(exif, info);
  }
  const long orientation = WholeNumber(exif, "Exif.Image.Orientation", 1);
  info->orientation = orientation >= 1 && orientation <= 8 ? static_cast<int>(orientation) : 1;
  const std::optional<double> focal_35mm = Number(exif, "Exif.Photo.FocalLengthIn35mmFilm");
  if (focal_35mm && *focal_35mm > 0.0) {
    info->focal_35mm = focal_35mm;
  }
}

}  // namespace

ExifInfo ReadExif(std::span<const uint8_t> image_bytes) {
  const ImageHeader header = ParseImageHeader(image_bytes);
  ExifInfo info;
  info.width_px = static_cast<int>(std::min<int64_t>(header.width_px, INT32_MAX));
  info.height_px = static_cast<int>(std::min<int64_t>(header.height_px, INT32_MAX));
  if (header.exif.empty()) {
    return info;
  }

  // Exiv2 prints warnings about odd EXIF. Such a photo merely has less usable EXIF.
  static const bool muted = (Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute), true);
  static_cast<void>(muted);
  ExifInfo tagged = info;
  try {
    Exiv2::ExifData exif;
    Exiv2::ExifParser::decode(exif, header.exif.data(), static_cast<uint32_t>(header.exif.size()));
    ReadTags(exif, &tagged);
  } catch (const Exiv2::Error&) {
    return info;
  }
  return tagged;
}

}  // namespace cairn
