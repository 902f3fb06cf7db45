#include "core/images/xmp_position.h"

#include <charconv>
#include <cmath>

#include "core/angles.h"

namespace cairn {
namespace {

constexpr double kMaxXmpAltitudeM = 10'000.0;

// The text of a property; empty if there is none.
std::string_view PropertyOf(std::string_view xmp, std::string_view name) {
  for (size_t at = xmp.find(name); at != xmp.npos; at = xmp.find(name, at + 1)) {
    std::string_view rest = xmp.substr(at + name.size());
    const bool is_attribute = rest.starts_with("=\"") || rest.starts_with("='");
    if (is_attribute || rest.starts_with('>')) {
      const char end = is_attribute ? rest[1] : '<';
      rest.remove_prefix(is_attribute ? 2 : 1);
      const size_t size = rest.find(end);
      return size == rest.npos ? std::string_view() : rest.substr(0, size);
    }
  }
  return {};
}

// Takes a finite number off the front of the text.
std::optional<double> TakeNumber(std::string_view* text) {
  if (text->starts_with('+')) {
    text->remove_prefix(1);
  }
  double number = 0.0;
  const auto [rest, error] = std::from_chars(text->data(), text->data() + text->size(), number);
  if (error != std::errc() || !std::isfinite(number)) {
    return std::nullopt;
  }
  text->remove_prefix(static_cast<size_t>(rest - text->data()));
  return number;
}

// A number, or a ratio of two.
std::optional<double> XmpNumberOf(std::string_view text) {
  std::optional<double> number = TakeNumber(&text);
  if (number && text.starts_with('/')) {
    text.remove_prefix(1);
    const std::optional<double> divisor = TakeNumber(&text);
    number = divisor && *divisor != 0.0 ? std::optional(*number / *divisor) : std::nullopt;
  }
  return text.empty() ? number : std::nullopt;
}

// "55,41.89N" or "55,41,53.4N": degrees, minutes and seconds, with a letter of `hemispheres`, the
// positive one first.
std::optional<double> XmpAngleDeg(std::string_view text, std::string_view hemispheres) {
  double angle_deg = 0.0;
  for (const double unit_deg : {1.0, 1.0 / 60.0, 1.0 / 3600.0}) {
    const std::optional<double> number = TakeNumber(&text);
    if (!number || *number < 0.0) {
      return std::nullopt;
    }
    angle_deg += unit_deg * *number;
    if (!text.starts_with(',')) {
      break;
    }
    text.remove_prefix(1);
  }
  if (text.size() != 1 || hemispheres.find(text[0]) == hemispheres.npos) {
    return std::nullopt;
  }
  return text[0] == hemispheres[0] ? angle_deg : -angle_deg;
}

std::optional<XmpPosition> PositionAt(const std::optional<double>& lat_deg,
                                      const std::optional<double>& lon_deg,
                                      const std::optional<double>& altitude_m) {
  if (!lat_deg || !lon_deg || std::abs(*lat_deg) > 90.0 || std::abs(*lon_deg) > 180.0 ||
      (*lat_deg == 0.0 && *lon_deg == 0.0)) {
    return std::nullopt;
  }
  XmpPosition found;
  found.has_altitude = altitude_m && std::abs(*altitude_m) <= kMaxXmpAltitudeM;
  found.position = {*lat_deg * kRadPerDeg, *lon_deg * kRadPerDeg,
                    found.has_altitude ? *altitude_m : 0.0};
  return found;
}

std::optional<XmpPosition> PositionOfEditor(std::string_view xmp) {
  if (PropertyOf(xmp, "exif:GPSStatus") == "V") {
    return std::nullopt;
  }
  std::optional<double> altitude_m = XmpNumberOf(PropertyOf(xmp, "exif:GPSAltitude"));
  if (altitude_m && PropertyOf(xmp, "exif:GPSAltitudeRef") == "1") {
    altitude_m = -*altitude_m;
  }
  return PositionAt(XmpAngleDeg(PropertyOf(xmp, "exif:GPSLatitude"), "NS"),
                    XmpAngleDeg(PropertyOf(xmp, "exif:GPSLongitude"), "EW"), altitude_m);
}

std::optional<XmpPosition> PositionOfDrone(std::string_view xmp) {
  // Early drones spell it so.
  const std::string_view misspelled = PropertyOf(xmp, "drone-dji:GpsLongtitude");
  const std::string_view longitude = PropertyOf(xmp, "drone-dji:GpsLongitude");
  return PositionAt(XmpNumberOf(PropertyOf(xmp, "drone-dji:GpsLatitude")),
                    XmpNumberOf(longitude.empty() ? misspelled : longitude),
                    XmpNumberOf(PropertyOf(xmp, "drone-dji:AbsoluteAltitude")));
}

}  // namespace

std::optional<XmpPosition> ReadXmpPosition(std::string_view xmp) {
  const std::optional<XmpPosition> of_editor = PositionOfEditor(xmp);
  return of_editor ? of_editor : PositionOfDrone(xmp);
}

}  // namespace cairn
