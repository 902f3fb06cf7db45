// Views of the parts of a tile. The parts may belong to a Tile or be decoded separately.
#ifndef CAIRN_STORAGE_TILE_TILE_VIEWS_H_
#define CAIRN_STORAGE_TILE_TILE_VIEWS_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>

#include "storage/ids.h"
#include "storage/tile/tile.h"

namespace cairn {

// The landmarks and the attributes of their descriptors, without the codes. The fields have the
// meaning they have in Tile. A view: valid as long as the arrays it refers to.
struct TileLandmarks {
  TileLandmarks() = default;
  TileLandmarks(const Tile& tile)  // NOLINT: a tile converts to its landmarks.
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

// The landmarks that each keyframe saw. The fields have the meaning they have in Tile. A view, like
// TileLandmarks.
struct TileCovisibility {
  TileCovisibility() = default;
  TileCovisibility(const Tile& tile)  // NOLINT: a tile converts to its covisibility.
      : keyframes(tile.keyframes),
        keyframe_begin(tile.keyframe_begin),
        keyframe_landmarks(tile.keyframe_landmarks) {}

  std::span<const TileKeyframe> keyframes;
  std::span<const uint32_t> keyframe_begin;  // num_keyframes + 1 offsets.
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
