#include "core/images/exif.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <string_view>

#include "core/angles.h"
#include "core/images/image_header.h"
#include "core/images/tiff_directory.h"
#include "core/random.h"

namespace cairn {
namespace {

// Tags of the first directory.
constexpr uint16_t kOrientationTag = 0x0112;
constexpr uint16_t kExifDirectoryTag = 0x8769;
constexpr uint16_t kGpsDirectoryTag = 0x8825;
constexpr uint16_t kMakeTag = 0x010f, kModelTag = 0x0110;
// Tags of the EXIF directory.
constexpr uint16_t kDateTimeOriginalTag = 0x9003;
constexpr uint16_t kPixelWidthTag = 0xa002, kPixelHeightTag = 0xa003;
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

// Reads "2026:11:26 10:12:00"; blanks and zeros stand for an unknown time.
std::optional<double> TimeOf(std::string_view text) {
  constexpr size_t kAt[] = {0, 5, 8, 11, 14, 17}, kDigits[] = {4, 2, 2, 2, 2, 2};
  constexpr std::string_view kForm = "0000:00:00 00:00:00";
  if (text.size() < kForm.size()) {
    return std::nullopt;
  }
  int values[6] = {};
  for (size_t i = 0; i < kForm.size(); ++i) {
    const bool is_digit = text[i] >= '0' && text[i] <= '9';
    if (is_digit != (kForm[i] == '0')) {
      return std::nullopt;
    }
  }
  for (size_t i = 0; i < 6; ++i) {
    std::from_chars(text.data() + kAt[i], text.data() + kAt[i] + kDigits[i], values[i]);
  }
  using std::chrono::day, std::chrono::month, std::chrono::year;
  const std::chrono::year_month_day date{year(values[0]), month(static_cast<unsigned>(values[1])),
                                         day(static_cast<unsigned>(values[2]))};
  if (!date.ok()) {
    return std::nullopt;
  }
  const auto days = std::chrono::sys_days(date).time_since_epoch().count();
  return 86400.0 * static_cast<double>(days) + 3600.0 * values[3] + 60.0 * values[4] + values[5];
}

uint64_t HashOf(std::string_view make, std::string_view model) {
  uint64_t hash = 0;
  for (const std::string_view text : {make, model}) {
    for (const char c : text) {
      hash = HashWord(hash ^ static_cast<uint8_t>(c));
    }
  }
  return hash;
}

int SideOf(const TiffDirectory& exif, uint16_t tag) {
  const double side = exif.Number(tag).value_or(0.0);
  return side >= 1.0 && side <= INT32_MAX ? static_cast<int>(side) : 0;
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
  info.camera_kind = HashOf(first.Text(kMakeTag), first.Text(kModelTag));
  const TiffDirectory exif = first.Pointed(kExifDirectoryTag);
  info.time_s = TimeOf(exif.Text(kDateTimeOriginalTag));
  info.original_width_px = SideOf(exif, kPixelWidthTag);
  info.original_height_px = SideOf(exif, kPixelHeightTag);
  const std::optional<double> focal_35mm = exif.Number(kFocalLengthIn35mmTag);
  if (focal_35mm && *focal_35mm > 0.0) {
    info.focal_35mm = focal_35mm;
  }
  return info;
}

}  // namespace cairn
