// The first global_from_local: from several answers that agree.
#ifndef CAIRN_FUSION_MAP_UPDATES_ALIGNMENT_H_
#define CAIRN_FUSION_MAP_UPDATES_ALIGNMENT_H_

#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/rigid3.h"
#include "fusion/filter/filter_state.h"
#include "fusion/map_updates/map_update.h"

namespace cairn::fusion {

struct AlignmentOptions {
  int min_agreeing = 3;  // Answers that must agree before anything is believed.
  // Answers agree if they place the camera within these of one another.
  double max_position_difference_m = 1.0;
  double max_yaw_difference_rad = 0.07;  // 4 degrees.
  // Largest tilt of an answer against the gravity of the filter.
  double max_tilt_rad = 0.0873;  // 5 degrees.
  // An alignment is given up after this many answers in a row that contradict it and agree with one
  // another, spread over this long a time.
  int min_contradictions = 5;
  double min_contradiction_span_s = 3.0;

  void Validate() const;
};

// The 4-DoF global_from_local (yaw and translation) nearest to a rigid one, keeping where it maps
// `x_in_local`; and by how much it was tilted.
struct LevelTransform {
  Rigid3d level;
  double tilt_rad = 0.0;
};
LevelTransform Level(const Rigid3d& global_from_local, const Eigen::Vector3d& x_in_local);

// True if two alignments agree about a camera at `x_in_local`.
bool Agree(const Rigid3d& a, const Rigid3d& b, const Eigen::Vector3d& x_in_local,
           const AlignmentOptions& options);

// Indices of the largest set of candidates that agree with one of them. All evaluated at
// `x_in_local`. The first of equals wins.
std::vector<int> LargestAgreeingSet(std::span<const Rigid3d> candidates,
                                    const Eigen::Vector3d& x_in_local,
                                    const AlignmentOptions& options);

// Robust (Cauchy) least squares of the reprojection errors over yaw, translation and, with a tilt
// prior, tilt; the clones held. Then the inliers enter `state` with exact covariance. False, with
// the state unchanged, if fewer than map.min_matches matches, or fewer than map.min_inlier_fraction
// of them, fit.
bool Align(const Camera& camera, std::span<const MapSight> sights, const Rigid3d& initial,
           const MapUpdateOptions& map, FilterState* state);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_MAP_UPDATES_ALIGNMENT_H_
