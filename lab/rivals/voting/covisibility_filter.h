// The covisibility filter: an alternative to pose voting.
#ifndef CAIRN_LAB_RIVALS_VOTING_COVISIBILITY_FILTER_H_
#define CAIRN_LAB_RIVALS_VOTING_COVISIBILITY_FILTER_H_

#include <vector>

#include "engine/query/localize_result.h"
#include "engine/query/pose_candidate.h"
#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"
#include "engine/voting/voting_options.h"

namespace cairn {

// Connected components of the bipartite graph of matched landmarks and the keyframes that saw them
// (paper, section "Co-Visibility-Based and Geometric Outlier Filtering"; Sattler, Leibe, Kobbelt,
// "Efficient & Effective Prioritized Matching", PAMI 2017); landmarks are recognised
// across tiles. Each component of at least options.min_score distinct keypoints is a candidate with
// that number as score, highest first, equal ones by their first correspondence, at most
// options.max_candidates. The literature keeps just the largest: max_candidates = 1. Centre and yaw
// are left at zero. Sets the voting counters. Linear in the matches
// times the tiles and in the sightings of their landmarks.
std::vector<PoseCandidate> CovisibilityCandidates(
    const std::vector<TileView>& tiles, const std::vector<Correspondence>& correspondences,
    const VotingOptions& options, StageCounters* counters);

// The options with this filter in the place of theirs.
VotingOptions WithCovisibility(VotingOptions options);

}  // namespace cairn

#endif  // CAIRN_LAB_RIVALS_VOTING_COVISIBILITY_FILTER_H_
