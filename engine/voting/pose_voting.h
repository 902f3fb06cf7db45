// Stage `voting`: 4D pose voting with known gravity (paper, section "Co-Visibility-Based and
// Geometric Outlier Filtering"; Zeisl, Sattler, Pollefeys, ICCV 2015).
#ifndef CAIRN_ENGINE_VOTING_POSE_VOTING_H_
#define CAIRN_ENGINE_VOTING_POSE_VOTING_H_

#include <vector>

#include "core/shared_workers.h"
#include "core/stop_function.h"
#include "engine/query/localize_result.h"
#include "engine/query/pose_candidate.h"
#include "engine/query/query_context.h"
#include "engine/voting/voting_options.h"

namespace cairn {

// Votes of all correspondences over (x, y, z, yaw), or, with OutlierFilter::kVoting3d, (x, y, yaw),
// within the region; returns the best maxima, in 4D settled on their rays (SettledCandidate),
// highest score first, each with the correspondences that agree with it. A keypoint counts at most
// once in a cell. The heights of candidates mean nothing if they were not voted over. Needs gravity
// (query.level_from_cam). Sets the voting counters. `workers` (may be null) share the work, by
// ranges of yaw; the result is the same.
//
// When `should_stop` says so, which it is asked for every heading and every candidate, the rest is
// left and there are no candidates.
std::vector<PoseCandidate> VoteForPoses(const QueryContext& query,
                                        const std::vector<Correspondence>& correspondences,
                                        const VotingOptions& options, StageCounters* counters,
                                        SharedWorkers* workers = nullptr,
                                        const StopFunction& should_stop = {});

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_POSE_VOTING_H_
