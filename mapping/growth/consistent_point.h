// The point that the most observations of a track agree on.
#ifndef CAIRN_MAPPING_GROWTH_CONSISTENT_POINT_H_
#define CAIRN_MAPPING_GROWTH_CONSISTENT_POINT_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/scene/triangulate.h"

namespace cairn {

// Smallest angle between two rays of a landmark, in standard deviations of the angle: its distance
// is then known within a sixth. On a walk straight ahead, most of what the next photo sees is far
// away, where a fixed angle of one degree would leave few landmarks.
inline constexpr double kMinRayAngleSigmas = 6.0;

struct ConsistentPoint {
  Eigen::Vector3d x_in_world;
  std::vector<int> observations;  // Those that agree, at least two, ascending.
};

// Triangulates a point from observations of which some may be wrong: those agree whose reprojection
// error is at most four standard deviations, as in the adjustment. Starts from the observations
// that agree with `guess`, if at least two do, else from all observations, else from pairs of them,
// wide apart first. Nothing if fewer than two observations agree or their rays span less than
// kMinRayAngleSigmas.
std::optional<ConsistentPoint> TriangulateConsistent(
    const std::vector<PointObservation>& observations,
    const std::optional<Eigen::Vector3d>& guess = {});

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_CONSISTENT_POINT_H_
