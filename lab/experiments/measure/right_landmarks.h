// Finds the matches that matching could make, judged by the true pose. Private to experiments.
#ifndef CAIRN_LAB_EXPERIMENTS_MEASURE_RIGHT_LANDMARKS_H_
#define CAIRN_LAB_EXPERIMENTS_MEASURE_RIGHT_LANDMARKS_H_

#include <vector>

#include "core/rigid3.h"
#include "engine/query/query_context.h"
#include "lab/experiments/measure/warm_tiles.h"

namespace cairn {

// Returns true if the landmark, projected with the true pose, is at the keypoint.
bool IsRight(const QueryContext& query, const Rigid3d& true_cam_from_anchor, int keypoint_idx,
             const Eigen::Vector3d& x_in_anchor, double sigma_m);

// Returns, for each keypoint, whether some tile has a right landmark with a near descriptor; see
// QueryMatches.
std::vector<bool> MatchableKeypoints(const PreparedQuery& query,
                                     const Rigid3d& true_cam_from_anchor);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_RIGHT_LANDMARKS_H_
