// Stage `pose`: LO-RANSAC over gravity two-point or P3P models, then robust 6-DoF refinement.
#ifndef CAIRN_ENGINE_POSE_ESTIMATE_POSE_H_
#define CAIRN_ENGINE_POSE_ESTIMATE_POSE_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/pose/pose_options.h"
#include "engine/pose/refine_pose.h"
#include "engine/query/pose_candidate.h"
#include "engine/query/query_context.h"

namespace cairn {

// Estimates the pose from samples of `subset` (indices into `correspondences`). Then gathers
// inliers among all correspondences, one per keypoint, and refines the pose on them. Returns
// nothing if no model has enough inliers, or if the solver needs gravity and the query has none.
// May miss poses with a lower consensus score (PoseEstimate::consensus) than `min_consensus`, which
// saves most of the time spent on a wrong candidate after a right one. Deterministic by seed.
std::optional<PoseEstimate> EstimatePose(const QueryContext& query,
                                         const std::vector<Correspondence>& correspondences,
                                         const std::vector<int>& subset, const PoseOptions& options,
                                         uint64_t seed, double min_consensus = 0.0);

// Returns those of `subset` that are no inliers of a pose, in the same order. Poses that are far
// apart share few inliers, so the rivals of a pose are found among these.
std::vector<int> Unexplained(const QueryContext& query,
                             const std::vector<Correspondence>& correspondences,
                             const std::vector<int>& subset, const Rigid3d& cam_from_anchor,
                             const PoseOptions& options);

// Refines the pose of `estimate` on its inliers among `correspondences`, which may differ from
// those it was estimated from. Returns the pose with the covariance and the evidence of these
// inliers; nothing if they are fewer than options.min_inliers.
std::optional<PoseEstimate> RefineEstimate(const QueryContext& query,
                                           const std::vector<Correspondence>& correspondences,
                                           PoseEstimate estimate, const PoseOptions& options);

// Returns the inliers that are right with a probability of one half at least
// (PoseEstimate::right_probabilities).
std::vector<int> LikelyInliers(const PoseEstimate& estimate);

// Refines an estimate of the functions above on its likely inliers, then gathers inliers again, and
// repeats while the evidence grows. Other inliers often agree with the pose by chance and pull it
// off.
PoseEstimate RefineOnLikelyInliers(const QueryContext& query,
                                   const std::vector<Correspondence>& correspondences,
                                   PoseEstimate estimate, const PoseOptions& options);

// What RefinePose is told of a correspondence, and its options.
PoseObservation ObservationOf(const QueryContext& query, const Correspondence& correspondence);
RefinePoseOptions RefinementOf(const PoseOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_ESTIMATE_POSE_H_
