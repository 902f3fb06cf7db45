// Two photos of a plane, which two relative poses explain.
#ifndef CAIRN_MAPPING_MATCHING_PLANE_PAIR_H_
#define CAIRN_MAPPING_MATCHING_PLANE_PAIR_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "core/rigid3.h"
#include "mapping/matching/relative_pose.h"

namespace cairn {

// The plane that most points of two photos lie on.
struct SeenPlane {
  // The unit normal, pointing away from camera a, over the distance of the plane from it, in units
  // of the baseline and the frame of a. A ray a meets the plane at the depth 1 / (a . normal_in_a).
  Eigen::Vector3d normal_in_a = Eigen::Vector3d::Zero();
  int num_explained = 0;  // Inliers that lie on it within four standard deviations.
};

// The plane of the matches `inliers` under a relative pose with a unit translation; the others may
// lie anywhere. Nothing if there are fewer than three, or all directions of rays are one.
// Deterministic by seed.
std::optional<SeenPlane> FitPlane(std::span<const RayMatch> matches, std::span<const int> inliers,
                                  const Rigid3d& b_from_a, uint64_t seed);

// A homography belongs to two relative poses and planes (Faugeras and Lustman 1988). In the other
// one, the normal and the translation have changed places: a walk along a wall becomes a turn
// beside a wall that is seen edge-on. Points on one side of the middle between the cameras are in
// front of both in both stories.
struct PlaneTwin {
  Rigid3d b_from_a;             // The translation has unit length.
  Eigen::Vector3d normal_in_a;  // Unit vector on the side of the points.
};

// The other pose, given one and its plane. `rays_in_a` is the sum of the rays of points of the
// plane. Nothing if both are the same within a degree, as without a baseline.
std::optional<PlaneTwin> TwinOf(const Rigid3d& b_from_a, const SeenPlane& plane,
                                const Eigen::Vector3d& rays_in_a);

}  // namespace cairn

#endif  // CAIRN_MAPPING_MATCHING_PLANE_PAIR_H_
