#include "core/images/exif.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <chrono>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/angles.h"
#include "core/images/image_header.h"
#include "core/images/raw_profile.h"
#include "core/images/tiff_directory.h"
#include "core/images/xmp_position.h"
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
constexpr uint16_t kFocalLengthTag = 0x920a, kDigitalZoomTag = 0xa404;
constexpr uint16_t kFocalPlaneAcrossTag = 0xa20e, kFocalPlaneAlongTag = 0xa20f;
constexpr uint16_t kFocalPlaneUnitTag = 0xa210;
// Tags of the GPS directory.
constexpr uint16_t kLatitudeRefTag = 0x01, kLatitudeTag = 0x02;
constexpr uint16_t kLongitudeRefTag = 0x03, kLongitudeTag = 0x04;
constexpr uint16_t kAltitudeRefTag = 0x05, kAltitudeTag = 0x06;
constexpr uint16_t kStatusTag = 0x09;
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
  info->gps_is_void = gps.Letter(kStatusTag) == 'V';
  if (info->gps_is_void) {
    return;
  }
  const char north_south = gps.Letter(kLatitudeRefTag), east_west = gps.Letter(kLongitudeRefTag);
  info->gps_lacks_hemisphere =
      (north_south != 'N' && north_south != 'S') || (east_west != 'E' && east_west != 'W');
  info->gps = Geodetic{*lat_rad, *lon_rad, 0.0};
  ReadAltitude(gps, info);
  const std::optional<double> error_m = gps.Number(kPositioningErrorTag);
  if (error_m && *error_m > 0.0) {
    info->gps_error_m = error_m;
  }
}

void TakeXmpPosition(std::string_view xmp, ExifInfo* info) {
  const std::optional<XmpPosition> found = ReadXmpPosition(xmp);
  if (found && !info->gps && !info->gps_is_void) {
    info->gps = found->position;
    info->has_altitude = found->has_altitude;
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

// The number of a tag of which zero and negative values stand for "unknown".
double PositiveOrZero(const TiffDirectory& exif, uint16_t tag) {
  return std::max(0.0, exif.Number(tag).value_or(0.0));
}

double DigitalZoom(const TiffDirectory& exif) {
  return std::max(1.0, exif.Number(kDigitalZoomTag).value_or(1.0));
}

uint64_t CameraKind(std::string_view make, std::string_view model, const TiffDirectory& exif) {
  uint64_t hash = 0;
  for (const std::string_view text : {make, model}) {
    for (const char c : text) {
      hash = HashWord(hash ^ static_cast<uint8_t>(c));
    }
  }
  // Numbers of a camera are rounded in the same way in all its photos.
  const double focal_mm = DigitalZoom(exif) * PositiveOrZero(exif, kFocalLengthTag);
  return focal_mm > 0.0 ? HashWord(hash ^ std::bit_cast<uint64_t>(focal_mm)) : hash;
}

int SideOf(const TiffDirectory& exif, uint16_t tag) {
  const double side = exif.Number(tag).value_or(0.0);
  return side >= 1.0 && side <= INT32_MAX ? static_cast<int>(side) : 0;
}

// Millimeters in a unit of the sensor's resolution: inches unless the tag says otherwise.
double MmOfFocalPlaneUnit(double unit) {
  constexpr double kUnitsMm[] = {25.4, 10.0, 1.0, 0.001};  // 2 to 5.
  return unit >= 2.0 && unit <= 5.0 ? kUnitsMm[static_cast<int>(unit) - 2] : kUnitsMm[0];
}

// Sensors that photos with these tags have: from the smallest of phones to medium format.
constexpr double kMinSensorMm = 3.0, kMaxSensorMm = 60.0;

// The focal length that the sensor tells: cameras with lenses (Canon's, among others) state the
// pixels an inch of the sensor for the size that they gave the picture, and no equivalent.
std::optional<double> Focal35MmOfSensor(const TiffDirectory& exif, const ExifInfo& info) {
  const double focal_mm = DigitalZoom(exif) * PositiveOrZero(exif, kFocalLengthTag);
  const double across = PositiveOrZero(exif, kFocalPlaneAcrossTag);
  const double along = PositiveOrZero(exif, kFocalPlaneAlongTag);
  if (!(focal_mm > 0.0 && across > 0.0)) {
    return std::nullopt;
  }
  const double sensor_mm = MmOfFocalPlaneUnit(exif.Number(kFocalPlaneUnitTag).value_or(2.0)) *
                           std::max(info.original_width_px / across,
                                    info.original_height_px / (along > 0.0 ? along : across));
  if (!(sensor_mm >= kMinSensorMm && sensor_mm <= kMaxSensorMm)) {
    return std::nullopt;
  }
  return focal_mm / sensor_mm * kFilmLongSideMm;
}

}  // namespace

ExifInfo ReadExif(std::span<const uint8_t> image_bytes) {
  const ImageHeader header = ParseImageHeader(image_bytes);
  ExifInfo info;
  info.width_px = static_cast<int>(std::min<int64_t>(header.width_px, INT32_MAX));
  info.height_px = static_cast<int>(std::min<int64_t>(header.height_px, INT32_MAX));
  TiffDirectory first = TiffDirectory::First(header.exif);
  std::vector<uint8_t> profile;
  if (first.IsEmpty() && !header.raw_profile.empty()) {
    profile = ReadRawProfile(header.raw_profile);
    first = TiffDirectory::First(profile);
  }
  ReadGps(first.Pointed(kGpsDirectoryTag), &info);
  TakeXmpPosition(header.xmp, &info);
  const double orientation = first.Number(kOrientationTag).value_or(1.0);
  info.orientation = orientation >= 1.0 && orientation <= 8.0 ? static_cast<int>(orientation) : 1;
  const TiffDirectory exif = first.Pointed(kExifDirectoryTag);
  info.camera_kind = CameraKind(first.Text(kMakeTag), first.Text(kModelTag), exif);
  info.time_s = TimeOf(exif.Text(kDateTimeOriginalTag));
  info.original_width_px = SideOf(exif, kPixelWidthTag);
  info.original_height_px = SideOf(exif, kPixelHeightTag);
  const std::optional<double> focal_35mm = exif.Number(kFocalLengthIn35mmTag);
  if (focal_35mm && *focal_35mm > 0.0) {
    info.focal_35mm = focal_35mm;
  } else {
    info.focal_35mm = Focal35MmOfSensor(exif, info);
  }
  return info;
}

}  // namespace cairn
