// Matched keypoints as rays of two cameras.
#ifndef CAIRN_MAPPING_MATCHING_PAIR_RAYS_H_
#define CAIRN_MAPPING_MATCHING_PAIR_RAYS_H_

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/scene/tracks.h"
#include "mapping/matching/relative_pose.h"
#include "mapping/photo_set.h"

namespace cairn {

// One photo's way from keypoints to rays.
struct RaySource {
  const MappingPhoto& photo;
  Camera camera;
  double sigma_factor = 1.0;  // Times the standard deviation of a keypoint.

  std::optional<Eigen::Vector3d> RayOf(int keypoint_idx) const;
  // Nothing if the camera cannot see along the ray, which is RayOf().
  std::optional<RaySpread> SpreadOf(int keypoint_idx, const Eigen::Vector3d& ray) const;
};

struct PairRays {
  std::vector<RayMatch> rays;
  std::vector<int> match_of_ray;
};

// Matches of which a camera cannot see one end are left out.
PairRays MakePairRays(const RaySource& a, const RaySource& b,
                      std::span<const FeatureMatch> matches);

}  // namespace cairn

#endif  // CAIRN_MAPPING_MATCHING_PAIR_RAYS_H_
