#include "engine/voting/ray_arrays.h"

#include <algorithm>

namespace cairn {

template <typename Scalar>
RayArrays<Scalar>::RayArrays(const std::vector<VoteRay>& rays, const Eigen::Vector3d& center)
    : num_rays(static_cast<int>(rays.size())), center_in_anchor(center) {
  correspondence_idxs.reserve(rays.size());
  voters.reserve(rays.size());
  int voter = 0, last_keypoint_idx = -1;
  for (const VoteRay& ray : rays) {
    voter += ray.keypoint_idx != last_keypoint_idx;
    last_keypoint_idx = ray.keypoint_idx;
    voters.push_back(voter);
    correspondence_idxs.push_back(ray.correspondence_idx);
  }
  const size_t padded = (rays.size() + kBlock - 1) / kBlock * kBlock;
  const auto fill = [&](std::vector<Scalar>* array, double padding, const auto& value_of) {
    array->assign(padded, static_cast<Scalar>(padding));
    std::transform(rays.begin(), rays.end(), array->begin(),
                   [&](const VoteRay& ray) { return static_cast<Scalar>(value_of(ray)); });
  };
  fill(&x, 0.0, [&](const VoteRay& ray) { return ray.x_in_anchor.x() - center.x(); });
  fill(&y, 0.0, [&](const VoteRay& ray) { return ray.x_in_anchor.y() - center.y(); });
  fill(&z, 0.0, [&](const VoteRay& ray) { return ray.x_in_anchor.z() - center.z(); });
  fill(&direction_x, 1.0, [](const VoteRay& ray) { return ray.direction_in_level.x(); });
  fill(&direction_y, 0.0, [](const VoteRay& ray) { return ray.direction_in_level.y(); });
  fill(&direction_z, 0.0, [](const VoteRay& ray) { return ray.direction_in_level.z(); });
  fill(&horizontal, 1.0, [](const VoteRay& ray) { return ray.horizontal; });
  fill(&view_x, 1.0, [](const VoteRay& ray) { return ray.view_azimuth.x(); });
  fill(&view_y, 0.0, [](const VoteRay& ray) { return ray.view_azimuth.y(); });
  fill(&min_distance_m, 1.0, [](const VoteRay& ray) { return ray.min_distance_m; });
  fill(&max_distance_m, -1.0, [](const VoteRay& ray) { return ray.max_distance_m; });
  if (std::any_of(rays.begin(), rays.end(),
                  [](const VoteRay& ray) { return !ray.origin_in_level.isZero(0.0); })) {
    fill(&origin_x, 0.0, [](const VoteRay& ray) { return ray.origin_in_level.x(); });
    fill(&origin_y, 0.0, [](const VoteRay& ray) { return ray.origin_in_level.y(); });
    fill(&origin_z, 0.0, [](const VoteRay& ray) { return ray.origin_in_level.z(); });
  }
}

template struct RayArrays<float>;
template struct RayArrays<double>;

}  // namespace cairn
