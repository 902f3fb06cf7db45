// A correspondence as a constraint on the camera's position and yaw.
#ifndef CAIRN_ENGINE_VOTING_VOTE_RAY_H_
#define CAIRN_ENGINE_VOTING_VOTE_RAY_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "engine/query_context.h"
#include "engine/voting/voting_options.h"

namespace cairn {

// For a given yaw the camera centre lies on the segment
//   C(l) = x_in_anchor - Rz(yaw) (origin_in_level + l direction_in_level),
// l in [min_distance_m, max_distance_m], where l is the distance to the landmark.
struct VoteRay {
  int correspondence_idx = 0;
  int keypoint_idx = 0;
  Eigen::Vector3d x_in_anchor;
  Eigen::Vector3d direction_in_level;  // Unit vector, from camera to landmark.
  // Where the ray starts; zero but for the further cameras of a rig.
  Eigen::Vector3d origin_in_level = Eigen::Vector3d::Zero();
  double horizontal = 0.0;       // Length of the horizontal part of the direction.
  Eigen::Vector2d view_azimuth;  // (cos, sin) from landmark to mapping camera.
  double min_distance_m = 0.0;
  double max_distance_m = 0.0;
};

// The rays of all correspondences that can vote at all, in order of keypoint, clipped by what does
// not depend on yaw: the largest distance, the size of the keypoint, the region's height band.
// Needs gravity. Linear in the correspondences if these are in order of keypoint.
std::vector<VoteRay> MakeVoteRays(const QueryContext& query,
                                  const std::vector<Correspondence>& correspondences,
                                  const VotingOptions& options);

// Part of a ray, as distances from the landmark.
struct VoteSegment {
  double begin_m = 0.0;
  double end_m = 0.0;
};

// The region as seen by rays: a vertical cylinder (infinite, heights are clipped already).
struct VoteDisc {
  Eigen::Vector2d center;
  double radius_m = 0.0;
};

// The part of a ray that lies within the disc for one yaw, if the azimuth of the view fits.
// `direction_xy` is the horizontal part of Rz(yaw) direction_in_level, `min_cosine` the cosine of
// the largest azimuth difference. The ray starts at the camera centre; for one that does not, move
// the disc by Rz(yaw) origin_in_level.
std::optional<VoteSegment> ClipToDisc(const VoteRay& ray, const Eigen::Vector2d& direction_xy,
                                      const VoteDisc& disc, double min_cosine);

// True if the camera at horizontal direction -direction_xy from the landmark sees it from within
// the angle of the mapping camera's azimuth.
inline bool AzimuthFits(const VoteRay& ray, const Eigen::Vector2d& direction_xy,
                        double min_cosine) {
  return -direction_xy.dot(ray.view_azimuth) >= min_cosine * ray.horizontal;
}

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_VOTE_RAY_H_
