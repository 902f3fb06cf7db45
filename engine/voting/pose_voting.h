// Stage `voting`: 4D pose voting with known gravity (paper, section "Co-Visibility-Based and
// Geometric Outlier Filtering"; Zeisl, Sattler, Pollefeys, ICCV 2015).
#ifndef CAIRN_ENGINE_VOTING_POSE_VOTING_H_
#define CAIRN_ENGINE_VOTING_POSE_VOTING_H_

#include <cstdint>
#include <vector>

#include "core/shared_workers.h"
#include "core/stop_function.h"
#include "engine/query/pose_candidate.h"
#include "engine/query/query_context.h"
#include "engine/voting/voting_options.h"

namespace cairn {

struct VotedPoses {
  std::vector<PoseCandidate> candidates;  // Best first.
  int64_t num_votes = 0;                  // Also if voting was stopped.
};

// Lets all correspondences vote over (x, y, z, yaw), or over (x, y, yaw) with
// OutlierFilter::kVoting3d, within the region. Returns the best maxima, highest score first, each
// with the correspondences that agree with it; in 4D, the maxima are settled on their rays
// (SettledCandidate). A keypoint counts at most once per cell. The heights of candidates are
// meaningless with kVoting3d. Needs gravity (query.level_from_cam). `workers`
// (may be null) share the work by ranges of yaw; the result does not depend on them.
//
// Polls `should_stop` for every heading and every candidate; once it returns true, voting stops and
// returns no candidates.
VotedPoses VoteForPoses(const QueryContext& query,
                        const std::vector<Correspondence>& correspondences,
                        const VotingOptions& options, SharedWorkers* workers = nullptr,
                        const StopFunction& should_stop = {});

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_POSE_VOTING_H_
