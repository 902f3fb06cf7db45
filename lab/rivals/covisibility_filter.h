// The covisibility filter, an alternative to pose voting.
#ifndef CAIRN_LAB_RIVALS_COVISIBILITY_FILTER_H_
#define CAIRN_LAB_RIVALS_COVISIBILITY_FILTER_H_

#include <vector>

#include "engine/query/localize_result.h"
#include "engine/query/pose_candidate.h"
#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"
#include "engine/voting/voting_options.h"

namespace cairn {

// Finds the connected components of the bipartite graph of matched landmarks and the keyframes that
// saw them (paper, section "Co-Visibility-Based and Geometric Outlier Filtering"; Sattler, Leibe,
// Kobbelt, "Efficient & Effective Prioritized Matching", PAMI 2017). Landmarks are identified
// across tiles.
//
// A component with at least options.min_score distinct keypoints becomes a candidate, whose score
// is that number. Candidates are in descending order of score; equal ones are in the order of their
// first correspondence. At most options.max_candidates are returned. The literature keeps only the
// largest component: max_candidates = 1. Center and yaw remain zero.
//
// Time is linear in the matches times the tiles, and in the history of the matched landmarks.
std::vector<PoseCandidate> CovisibilityCandidates(
    const std::vector<TileView>& tiles, const std::vector<Correspondence>& correspondences,
    const VotingOptions& options);

// Returns the options with this filter in place of their own.
VotingOptions WithCovisibility(VotingOptions options);

}  // namespace cairn

#endif  // CAIRN_LAB_RIVALS_COVISIBILITY_FILTER_H_
