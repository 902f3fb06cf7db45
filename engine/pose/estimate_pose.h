// Stage `pose`: LO-RANSAC over gravity two-point or P3P models, then robust 6-DoF refinement.
#ifndef CAIRN_ENGINE_POSE_ESTIMATE_POSE_H_
#define CAIRN_ENGINE_POSE_ESTIMATE_POSE_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/pose/pose_options.h"
#include "engine/query/pose_candidate.h"
#include "engine/query/query_context.h"

namespace cairn {

// Estimates the pose from `subset` (indices into `correspondences`; samples are drawn from it),
// then gathers inliers among all correspondences, one per keypoint, and refines on them. Nothing if
// no model has enough inliers, or the solver needs gravity and the query has none. Poses with a
// lower consensus score (PoseEstimate::consensus) than `min_consensus` may be missed, which saves
// most of the time of a wrong candidate after a right one. Deterministic by seed.
std::optional<PoseEstimate> EstimatePose(const QueryContext& query,
                                         const std::vector<Correspondence>& correspondences,
                                         const std::vector<int>& subset, const PoseOptions& options,
                                         uint64_t seed, double min_consensus = 0.0);

// The pose of `estimate` refined on its inliers among `correspondences`, which need not be those it
// was estimated from, with the covariance and the evidence that they give it. Nothing if
// they are fewer than options.min_inliers.
std::optional<PoseEstimate> RefineEstimate(const QueryContext& query,
                                           const std::vector<Correspondence>& correspondences,
                                           PoseEstimate estimate, const PoseOptions& options);

// Refines on those inliers of `estimate`, an answer of the functions above, that are more likely
// right than not by their evidence (PoseEstimate::right_probabilities), gathers inliers anew, and
// repeats it while the evidence grows. Lenient matches agree with a pose by chance and pull at it.
PoseEstimate RefineOnLikelyInliers(const QueryContext& query,
                                   const std::vector<Correspondence>& correspondences,
                                   PoseEstimate estimate, const PoseOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_ESTIMATE_POSE_H_
