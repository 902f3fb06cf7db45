// A match between a frame and the map.
#ifndef CAIRN_FUSION_MAP_UPDATES_MAP_MATCH_H_
#define CAIRN_FUSION_MAP_UPDATES_MAP_MATCH_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>

namespace cairn::fusion {

// A landmark of the map that a queried frame sees.
struct MapMatch {
  Eigen::Vector2d pixel;
  std::optional<uint64_t> track_id;  // Set if the keypoint is a tracked feature.
  Eigen::Vector3d x_in_global;
  double sigma_m = 0.0;  // Standard deviation of the landmark per axis.
  uint64_t landmark_id = 0;
  uint64_t tile_id = 0;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_MAP_UPDATES_MAP_MATCH_H_
