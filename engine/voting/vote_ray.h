// A correspondence as a constraint on the camera's position and yaw.
#ifndef CAIRN_ENGINE_VOTING_VOTE_RAY_H_
#define CAIRN_ENGINE_VOTING_VOTE_RAY_H_

#include <Eigen/Core>
#include <vector>

#include "engine/query/query_context.h"
#include "engine/voting/voting_options.h"

namespace cairn {

// For a given yaw, the camera center lies on the segment
//   C(l) = x_in_anchor - Rz(yaw) (origin_in_level + l direction_in_level),
// where l in [min_distance_m, max_distance_m] is the distance to the landmark.
struct VoteRay {
  int correspondence_idx = 0;
  int keypoint_idx = 0;
  Eigen::Vector3d x_in_anchor;
  Eigen::Vector3d direction_in_level;  // Unit vector, from camera to landmark.
  // Where the ray starts. Zero except for the other cameras of a rig.
  Eigen::Vector3d origin_in_level = Eigen::Vector3d::Zero();
  double horizontal = 0.0;       // Length of the horizontal part of the direction.
  Eigen::Vector2d view_azimuth;  // (cos, sin) from landmark to mapping camera.
  double min_distance_m = 0.0;
  double max_distance_m = 0.0;
};

// Returns the rays of all correspondences that can vote, in order of keypoint. Their distances are
// clipped by the constraints that do not depend on yaw: the largest distance, the size of the
// keypoint, and the region's height band. Needs gravity. Takes linear time if the correspondences
// are in order of keypoint.
std::vector<VoteRay> MakeVoteRays(const QueryContext& query,
                                  const std::vector<Correspondence>& correspondences,
                                  const VotingOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_VOTE_RAY_H_
