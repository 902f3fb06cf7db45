// Alignment: finds the first global_from_local from several answers of the map that agree.
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

// `level` is the 4-DoF transform (yaw and translation) nearest to a rigid global_from_local; both
// map `x_in_local` to the same point. `tilt_rad` is the rotation angle between the two.
struct LevelTransform {
  Rigid3d level;
  double tilt_rad = 0.0;
};
LevelTransform Level(const Rigid3d& global_from_local, const Eigen::Vector3d& x_in_local);

// Returns true if the two global_from_local transforms agree for a camera at `x_in_local`:
// within 1 m and 4 degrees.
bool Agree(const Rigid3d& a, const Rigid3d& b, const Eigen::Vector3d& x_in_local);

// Returns the indices of the largest set of candidates that all agree with one member of the set.
// Evaluates every candidate at `x_in_local`. If two sets have the same size, the first wins.
std::vector<int> LargestAgreeingSet(std::span<const Rigid3d> candidates,
                                    const Eigen::Vector3d& x_in_local);

// Minimizes the reprojection errors by robust (Cauchy) least squares over yaw and translation, with
// the clones held fixed. The inliers then enter `state` with exact covariance; they determine the
// tilt, too, if the options have a tilt prior. Returns false and leaves `state` unchanged if fewer
// than kMinMapMatches matches, or a smaller share of them than kMinMapInlierFraction, fit.
bool Align(const Camera& camera, std::span<const MapObservation> observations,
           const Rigid3d& initial, const MapUpdateOptions& map, FilterState* state);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_MAP_UPDATES_ALIGNMENT_H_
