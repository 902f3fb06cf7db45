// The id of a 150 m map tile on the UTM/UPS grid.
#ifndef CAIRN_CORE_TILE_ID_H_
#define CAIRN_CORE_TILE_ID_H_

#include <compare>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geodesy.h"

namespace cairn {

// A square of the 150 m grid of a UTM zone (near the poles, UPS). Squares of two zones overlap.
//
// Bit layout of the 64-bit value, most significant first:
//   63..59  zero, so that the value is positive as an SQLite integer
//   58..53  zone, 1 to 60; 0 is UPS
//   52      hemisphere, 1 is north
//   51..26  easting index  = floor(easting / 150 m)
//   25..0   northing index = floor(northing / 150 m)
// Printed as "32N-03104-35120": zone, hemisphere letter, easting index, northing index.
class TileId {
 public:
  static constexpr double kSideM = 150.0;

  TileId() = default;  // Invalid; value() is 0.

  // Returns the tile that contains a position, in the position's standard zone.
  static TileId Containing(const Geodetic& position);

  // Throw Error(kBadInput) if the bits or the text do not name a tile on Earth.
  static TileId FromValue(uint64_t value);
  static TileId Parse(std::string_view text);

  // Returns the square of the same zone and hemisphere with other indices, of [0, 2^26). The square
  // need not lie on Earth, unlike those of the other factories, because that takes a projection.
  TileId WithIndices(int easting_idx, int northing_idx) const;

  uint64_t value() const { return value_; }
  int zone() const;
  bool north() const;
  int easting_idx() const;
  int northing_idx() const;
  std::string ToString() const;

  // Returns the center of the square at ellipsoidal height 0, the origin of the tile frame.
  Geodetic Anchor() const;

  // Returns the four corners, counter-clockwise from the south-west, at height 0.
  std::vector<Geodetic> Corners() const;

  // Returns the box around the square.
  GeoBox Bounds() const;

  auto operator<=>(const TileId&) const = default;

 private:
  explicit TileId(uint64_t value) : value_(value) {}
  uint64_t value_ = 0;
};

}  // namespace cairn

template <>
struct std::hash<cairn::TileId> {
  size_t operator()(const cairn::TileId& id) const noexcept {
    return std::hash<uint64_t>()(id.value());
  }
};

#endif  // CAIRN_CORE_TILE_ID_H_
