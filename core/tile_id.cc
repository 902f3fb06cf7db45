#include "core/tile_id.h"

#include <fmt/format.h>

#include <GeographicLib/UTMUPS.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <exception>

#include "core/angles.h"
#include "core/check.h"
#include "core/error.h"
#include "core/printable.h"

namespace cairn {
namespace {

using GeographicLib::UTMUPS;

constexpr int kIndexBits = 26;
constexpr uint64_t kIndexMask = (uint64_t{1} << kIndexBits) - 1;

uint64_t Pack(int zone, bool north, int64_t easting_idx, int64_t northing_idx) {
  return static_cast<uint64_t>(zone) << (2 * kIndexBits + 1) |
         static_cast<uint64_t>(north) << (2 * kIndexBits) |
         static_cast<uint64_t>(easting_idx) << kIndexBits | static_cast<uint64_t>(northing_idx);
}

// Returns the position of a grid point, given in meters east and north in the zone.
Geodetic GeodeticFromGrid(int zone, bool north, double easting_m, double northing_m) {
  double lat_deg = 0.0, lon_deg = 0.0;
  UTMUPS::Reverse(zone, north, easting_m, northing_m, lat_deg, lon_deg);
  return Geodetic::FromDegrees(lat_deg, lon_deg, 0.0);
}

// Parses an unsigned decimal number of exactly `num_digits` digits; returns -1 if the text is not
// one.
int64_t ParseDigits(std::string_view text, size_t num_digits) {
  int64_t value = 0;
  if (text.size() != num_digits || text.front() < '0' || text.front() > '9') {
    return -1;
  }
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : -1;
}

}  // namespace

TileId TileId::Containing(const Geodetic& position) {
  ValidateGeodetic(position, "tile position");
  int zone = 0;
  bool north = false;
  double easting_m = 0.0, northing_m = 0.0;
  try {
    UTMUPS::Forward(position.lat_deg(), position.lon_deg(), zone, north, easting_m, northing_m);
  } catch (const std::exception& error) {
    throw Error(ErrorCode::kBadInput, fmt::format("no tile at this position: {}", error.what()));
  }
  return TileId(Pack(zone, north, static_cast<int64_t>(std::floor(easting_m / kSideM)),
                     static_cast<int64_t>(std::floor(northing_m / kSideM))));
}

TileId TileId::FromValue(uint64_t value) {
  const TileId id(value);
  const auto refuse = [value] {
    return Error(ErrorCode::kBadInput, fmt::format("{} is not a tile id", value));
  };
  if (value >> (2 * kIndexBits + 7) != 0 || id.zone() > UTMUPS::MAXZONE) {
    throw refuse();
  }
  try {
    id.Anchor();
  } catch (const std::exception&) {
    throw refuse();
  }
  return id;
}

TileId TileId::Parse(std::string_view text) {
  const auto refuse = [text] {
    return Error(
        ErrorCode::kBadInput,
        fmt::format("'{}' is not a tile id; an example of one is 32N-03104-35120", Excerpt(text)));
  };
  if (text.size() != 15 || (text[2] != 'N' && text[2] != 'S') || text[3] != '-' || text[9] != '-') {
    throw refuse();
  }
  const int64_t zone = ParseDigits(text.substr(0, 2), 2);
  const int64_t easting_idx = ParseDigits(text.substr(4, 5), 5);
  const int64_t northing_idx = ParseDigits(text.substr(10, 5), 5);
  if (zone < 0 || zone > UTMUPS::MAXZONE || easting_idx < 0 || northing_idx < 0) {
    throw refuse();
  }
  return FromValue(Pack(static_cast<int>(zone), text[2] == 'N', easting_idx, northing_idx));
}

TileId TileId::WithIndices(int easting_idx, int northing_idx) const {
  CAIRN_CHECK(easting_idx >= 0 && northing_idx >= 0 &&
                  easting_idx <= static_cast<int>(kIndexMask) &&
                  northing_idx <= static_cast<int>(kIndexMask),
              "an index has 26 bits");
  return TileId(Pack(zone(), north(), easting_idx, northing_idx));
}

int TileId::zone() const { return static_cast<int>(value_ >> (2 * kIndexBits + 1)); }
bool TileId::north() const { return (value_ >> (2 * kIndexBits) & 1) != 0; }
int TileId::easting_idx() const { return static_cast<int>(value_ >> kIndexBits & kIndexMask); }
int TileId::northing_idx() const { return static_cast<int>(value_ & kIndexMask); }

std::string TileId::ToString() const {
  return fmt::format("{:02}{}-{:05}-{:05}", zone(), north() ? 'N' : 'S', easting_idx(),
                     northing_idx());
}

Geodetic TileId::Anchor() const {
  return GeodeticFromGrid(zone(), north(), (easting_idx() + 0.5) * kSideM,
                          (northing_idx() + 0.5) * kSideM);
}

std::vector<Geodetic> TileId::Corners() const {
  std::vector<Geodetic> corners;
  for (const auto& [east, north_step] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
    corners.push_back(GeodeticFromGrid(zone(), north(), (easting_idx() + east) * kSideM,
                                       (northing_idx() + north_step) * kSideM));
  }
  return corners;
}

GeoBox TileId::Bounds() const {
  const Geodetic anchor = Anchor();
  GeoBox box{anchor.lat_rad, anchor.lon_rad, anchor.lat_rad, anchor.lon_rad};
  double min_lon_offset_rad = 0.0, max_lon_offset_rad = 0.0;
  for (const Geodetic& corner : Corners()) {
    const double offset_rad = std::remainder(corner.lon_rad - anchor.lon_rad, 2.0 * kPi);
    min_lon_offset_rad = std::min(min_lon_offset_rad, offset_rad);
    max_lon_offset_rad = std::max(max_lon_offset_rad, offset_rad);
    box.south_rad = std::min(box.south_rad, corner.lat_rad);
    box.north_rad = std::max(box.north_rad, corner.lat_rad);
  }
  if (max_lon_offset_rad - min_lon_offset_rad >= kPi) {  // The tile contains a pole.
    const double pole_rad = std::copysign(0.5 * kPi, anchor.lat_rad);
    box.south_rad = std::min(box.south_rad, pole_rad);
    box.north_rad = std::max(box.north_rad, pole_rad);
    box.west_rad = -kPi;
    box.east_rad = kPi;
    return box;
  }
  box.west_rad = std::remainder(anchor.lon_rad + min_lon_offset_rad, 2.0 * kPi);
  box.east_rad = std::remainder(anchor.lon_rad + max_lon_offset_rad, 2.0 * kPi);
  return box;
}

}  // namespace cairn
