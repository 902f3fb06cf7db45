#include "engine/refinement/near_keyframes.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace cairn {

std::vector<KeyframeRef> NearKeyframes(const std::vector<TileView>& tiles,
                                       const Rigid3d& anchor_from_cam, int max_count) {
  constexpr double kMinCosine = 0.5;  // 60 degrees between the viewing directions.
  struct Near {
    double sq_distance = 0.0;
    KeyframeRef keyframe;
  };
  std::vector<Near> near;
  for (int t = 0; t < static_cast<int>(tiles.size()); ++t) {
    const Rigid3d tile_from_cam = tiles[t].anchor_from_tile.Inverse() * anchor_from_cam;
    const Eigen::Vector3d view_in_tile = tile_from_cam.rotation * Eigen::Vector3d::UnitZ();
    const auto keyframes = tiles[t].tile->covisibility().keyframes;
    for (uint32_t k = 0; k < keyframes.size(); ++k) {
      const Rigid3d& cam_from_tile = keyframes[k].cam_from_tile;
      if ((cam_from_tile.rotation * view_in_tile).z() > kMinCosine) {
        near.push_back({(cam_from_tile * tile_from_cam.translation).squaredNorm(), {t, k}});
      }
    }
  }
  const size_t count = std::min(near.size(), static_cast<size_t>(max_count));
  std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end(),
                    [](const Near& a, const Near& b) { return a.sq_distance < b.sq_distance; });
  std::vector<KeyframeRef> keyframes;
  for (size_t i = 0; i < count; ++i) {
    keyframes.push_back(near[i].keyframe);
  }
  return keyframes;
}

}  // namespace cairn
