// Parts of a tile for readers, wherever they stand in memory: in a Tile, or decoded by themselves.
#ifndef CAIRN_STORAGE_TILE_TILE_VIEWS_H_
#define CAIRN_STORAGE_TILE_TILE_VIEWS_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>

#include "storage/ids.h"
#include "storage/tile/tile.h"

namespace cairn {

// Landmarks and what is known of their descriptors, but for the codes; the fields are those of
// Tile. A view: valid as long as what it was made of.
struct TileLandmarks {
  TileLandmarks() = default;
  TileLandmarks(const Tile& tile)  // NOLINT: a tile may stand for its landmarks.
      : landmark_ids(tile.landmark_ids),
        x_in_tile(tile.x_in_tile),
        sigma_codes(tile.sigma_codes),
        descriptor_begin(tile.descriptor_begin),
        orientation_codes(tile.orientation_codes),
        size_codes(tile.size_codes),
        azimuth_codes(tile.azimuth_codes) {}

  // Per landmark; descriptor_begin has one more.
  std::span<const LandmarkId> landmark_ids;
  std::span<const Eigen::Vector3f> x_in_tile;
  std::span<const uint8_t> sigma_codes;
  std::span<const uint32_t> descriptor_begin;

  // Per descriptor.
  std::span<const uint8_t> orientation_codes;
  std::span<const uint8_t> size_codes;
  std::span<const uint8_t> azimuth_codes;

  size_t num_landmarks() const { return x_in_tile.size(); }
  size_t num_descriptors() const { return orientation_codes.size(); }
};

// Which keyframes saw which landmarks; the fields are those of Tile. A view, as TileLandmarks.
struct TileCovisibility {
  TileCovisibility() = default;
  TileCovisibility(const Tile& tile)  // NOLINT: a tile may stand for its covisibility.
      : keyframes(tile.keyframes),
        keyframe_begin(tile.keyframe_begin),
        keyframe_landmarks(tile.keyframe_landmarks) {}

  std::span<const TileKeyframe> keyframes;
  std::span<const uint32_t> keyframe_begin;  // One more than there are keyframes.
  std::span<const uint32_t> keyframe_landmarks;

  size_t num_keyframes() const { return keyframes.size(); }
  std::span<const uint32_t> LandmarksOfKeyframe(size_t keyframe_idx) const {
    return keyframe_landmarks.subspan(
        keyframe_begin[keyframe_idx],
        keyframe_begin[keyframe_idx + 1] - keyframe_begin[keyframe_idx]);
  }
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_VIEWS_H_
