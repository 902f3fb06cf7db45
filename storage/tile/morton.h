// Morton (Z-order) codes of quantized tile positions. Private to storage.
#ifndef CAIRN_STORAGE_TILE_MORTON_H_
#define CAIRN_STORAGE_TILE_MORTON_H_

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <span>

#include "storage/tile/tile.h"
#include "storage/tile/tile_checks.h"

namespace cairn {

// Moves bit i of a 21-bit number to bit 3 i.
constexpr uint64_t SpreadBits(uint64_t value) {
  value = (value | value << 32) & 0x001f00000000ffff;
  value = (value | value << 16) & 0x001f0000ff0000ff;
  value = (value | value << 8) & 0x100f00f00f00f00f;
  value = (value | value << 4) & 0x10c30c30c30c30c3;
  value = (value | value << 2) & 0x1249249249249249;
  return value;
}

// The inverse of SpreadBits; ignores the other bits.
constexpr uint64_t GatherBits(uint64_t value) {
  value &= 0x1249249249249249;
  value = (value | value >> 2) & 0x10c30c30c30c30c3;
  value = (value | value >> 4) & 0x100f00f00f00f00f;
  value = (value | value >> 8) & 0x001f0000ff0000ff;
  value = (value | value >> 16) & 0x001f00000000ffff;
  value = (value | value >> 32) & 0x1fffff;
  return value;
}

// Returns the 63-bit code of a quantized position. Each triple of bits holds x (lowest), y, z. Each
// coordinate counts steps of Tile::kPositionStepM from -4096 m.
inline uint64_t MortonFromPosition(const Eigen::Vector3f& x_in_tile) {
  constexpr auto kStepsPerM = static_cast<float>(1.0 / Tile::kPositionStepM);
  const auto steps = [](float coordinate_m) {
    return static_cast<uint64_t>(static_cast<int64_t>(coordinate_m * kStepsPerM) +
                                 kMaxPositionSteps);
  };
  return SpreadBits(steps(x_in_tile.x())) | SpreadBits(steps(x_in_tile.y())) << 1 |
         SpreadBits(steps(x_in_tile.z())) << 2;
}

// The inverse of MortonFromPosition; ignores bit 63.
inline Eigen::Vector3f PositionFromMorton(uint64_t code) {
  constexpr auto kStepM = static_cast<float>(Tile::kPositionStepM);
  const auto coordinate_m = [](uint64_t steps) {
    return static_cast<float>(static_cast<int>(steps) - kMaxPositionSteps) * kStepM;
  };
  return {coordinate_m(GatherBits(code)), coordinate_m(GatherBits(code >> 1)),
          coordinate_m(GatherBits(code >> 2))};
}

// Decodes many codes at once. `x_in_tile` must have room for codes.size() positions.
void PositionsFromMorton(std::span<const uint64_t> codes, Eigen::Vector3f* x_in_tile);

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_MORTON_H_
