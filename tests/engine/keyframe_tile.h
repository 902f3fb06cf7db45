// Builds tiles from covisibility that is written by hand.
#ifndef CAIRN_TESTS_ENGINE_KEYFRAME_TILE_H_
#define CAIRN_TESTS_ENGINE_KEYFRAME_TILE_H_

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"
#include "support/tile_builder.h"

namespace cairn::testing {

// Keyframe k is at (x_m, 0, 0), looks east and sees `landmark_ids`.
struct KeyframeSpec {
  double x_m = 0.0;
  std::vector<uint64_t> landmark_ids;
};

// Returns a tile with the landmarks [first_id, first_id + num_landmarks). Indices are in the order
// of the ids.
inline TileView MakeTile(uint64_t first_id, int num_landmarks,
                         const std::vector<KeyframeSpec>& keyframes) {
  static const auto codebook = std::make_shared<const Codebook>(RandomCodebook());
  RandomTileOptions options;
  options.num_landmarks = num_landmarks;
  options.first_landmark_id = first_id;
  options.num_keyframes = 0;
  Tile tile = RandomTile(options);
  Eigen::Matrix3d tile_from_cam;  // Looks east: x (right) is south, y is down.
  tile_from_cam << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  for (const KeyframeSpec& keyframe : keyframes) {
    tile.keyframes.push_back(
        {KeyframeId(1), SessionId(1),
         Rigid3d(tile_from_cam, Eigen::Vector3d(keyframe.x_m, 0, 0)).Inverse()});
    for (const uint64_t id : keyframe.landmark_ids) {
      tile.keyframe_landmarks.push_back(static_cast<uint32_t>(id - first_id));
    }
    tile.keyframe_begin.push_back(static_cast<uint32_t>(tile.keyframe_landmarks.size()));
  }
  return {std::make_shared<SearchableTile>(std::move(tile), codebook, IndexOptions()), Rigid3d()};
}

inline std::vector<uint64_t> Range(uint64_t first, uint64_t last) {
  std::vector<uint64_t> ids;
  for (uint64_t id = first; id <= last; ++id) {
    ids.push_back(id);
  }
  return ids;
}

inline Correspondence Match(int keypoint_idx, int tile_idx, uint32_t landmark_idx) {
  Correspondence match;
  match.keypoint_idx = keypoint_idx;
  match.tile_idx = tile_idx;
  match.landmark_idx = landmark_idx;
  match.x_in_anchor.setZero();  // Covisibility does not use the position.
  return match;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_ENGINE_KEYFRAME_TILE_H_
