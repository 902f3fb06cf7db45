// Rays as arrays, for loops that the compiler vectorizes.
#ifndef CAIRN_ENGINE_VOTING_RAY_ARRAYS_H_
#define CAIRN_ENGINE_VOTING_RAY_ARRAYS_H_

#include <Eigen/Core>
#include <vector>

#include "engine/voting/vote_ray.h"

namespace cairn {

// Element i of every array belongs to ray i and has the meaning of VoteRay's member. Positions are
// relative to `center_in_anchor`. The arrays are padded to a multiple of kBlock with rays whose
// range of distances is empty.
template <typename Scalar>
struct RayArrays {
  static constexpr int kBlock = 16;

  RayArrays(const std::vector<VoteRay>& rays, const Eigen::Vector3d& center);

  int padded_size() const { return static_cast<int>(x.size()); }
  bool has_origins() const { return !origin_x.empty(); }

  int num_rays = 0;
  Eigen::Vector3d center_in_anchor;
  std::vector<int> correspondence_idxs;  // num_rays elements.
  // The rank of each ray's keypoint among the keypoints that have rays, from 1; num_rays elements,
  // ascending.
  std::vector<int> voters;
  std::vector<Scalar> x, y, z;  // The landmark.
  std::vector<Scalar> direction_x, direction_y, direction_z;
  std::vector<Scalar> horizontal, view_x, view_y;
  std::vector<Scalar> min_distance_m, max_distance_m;
  std::vector<Scalar> origin_x, origin_y, origin_z;  // Empty if all rays start at zero.
};

// The arrays as bare pointers. The compiler vectorizes loops over pointers, but not loops over
// vectors.
template <typename Scalar>
struct RayPointers {
  explicit RayPointers(const RayArrays<Scalar>& rays)
      : x(rays.x.data()),
        y(rays.y.data()),
        z(rays.z.data()),
        direction_x(rays.direction_x.data()),
        direction_y(rays.direction_y.data()),
        direction_z(rays.direction_z.data()),
        horizontal(rays.horizontal.data()),
        view_x(rays.view_x.data()),
        view_y(rays.view_y.data()),
        min_distance_m(rays.min_distance_m.data()),
        max_distance_m(rays.max_distance_m.data()),
        origin_x(rays.origin_x.data()),
        origin_y(rays.origin_y.data()),
        origin_z(rays.origin_z.data()) {}

  const Scalar *x, *y, *z, *direction_x, *direction_y, *direction_z, *horizontal, *view_x, *view_y;
  const Scalar *min_distance_m, *max_distance_m, *origin_x, *origin_y, *origin_z;
};

extern template struct RayArrays<float>;
extern template struct RayArrays<double>;

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_RAY_ARRAYS_H_
