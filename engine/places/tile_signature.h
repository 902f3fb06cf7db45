// The few descriptors of a tile by which a photo without a prior recognizes the tile.
#ifndef CAIRN_ENGINE_PLACES_TILE_SIGNATURE_H_
#define CAIRN_ENGINE_PLACES_TILE_SIGNATURE_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/tile_id.h"
#include "storage/tile/tile.h"

namespace cairn {

// The square of a tile is divided into cells, in rows from the south-west.
struct PlaceCells {
  static constexpr int kPerSide = 6;
  static constexpr int kPerTile = kPerSide * kPerSide;
  static constexpr double kSideM = TileId::kSideM / kPerSide;

  // Returns the cell of a position in the tile frame; that of the nearest position of the square if
  // the position is outside.
  static uint8_t Containing(const Eigen::Vector2d& xy_in_tile);
};

// What a descriptor says about the camera that sees it.
struct PlaceTraits {
  uint8_t cell = 0;  // In the middle of the keyframes that saw the landmark.
  uint8_t orientation_code = 0, azimuth_code = 0;  // As in Tile.
};

// A plain value that follows from the content of the tile.
struct TileSignature {
  TileId id;
  std::vector<uint8_t> codes;       // size() rows, as in Tile.
  std::vector<PlaceTraits> traits;  // Per descriptor.

  size_t size() const { return traits.size(); }
  size_t MemoryBytes() const {
    return sizeof(*this) + codes.capacity() + traits.capacity() * sizeof(PlaceTraits);
  }
};

// Takes at most this many descriptors, of landmarks that are spread evenly over the tile's order of
// landmarks, which is a curve through its space. A shorter signature is a prefix of a longer one.
// Landmarks that many keyframes saw tell no more than others: of those, too many are large things
// that are seen from afar, and a phone sees things nearby. Linear in the tile's size.
TileSignature MakeTileSignature(const Tile& tile, size_t max_descriptors);

}  // namespace cairn

#endif  // CAIRN_ENGINE_PLACES_TILE_SIGNATURE_H_
