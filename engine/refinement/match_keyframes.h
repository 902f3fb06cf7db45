// Stage `refinement`: matches the query again, against what single keyframes saw.
#ifndef CAIRN_ENGINE_REFINEMENT_MATCH_KEYFRAMES_H_
#define CAIRN_ENGINE_REFINEMENT_MATCH_KEYFRAMES_H_

#include <cstdint>
#include <vector>

#include "engine/matching/matching_options.h"
#include "engine/pose/pose_hypotheses.h"
#include "engine/pose/pose_options.h"
#include "engine/refinement/refinement_options.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Whether the poses so far are too weak to go without refinement; see RefinementOptions::mode.
bool NeedsRefinement(const PoseHypotheses& hypotheses, const RefinementOptions& options);

// Matches the query against the keyframes that see what the best poses so far explain and those
// that got most matches, each with its neighbours, and estimates a pose from each. Adds what it
// finds to `hypotheses`.
void MatchKeyframes(const QueryContext& query, const std::vector<TileView>& tiles,
                    const std::vector<Correspondence>& matches, const RefinementOptions& options,
                    const MatchingOptions& matching, const PoseOptions& pose, uint64_t seed,
                    const QueryBudget& budget, PoseHypotheses* hypotheses, StageCounters* counters);

// Whether gravity may be wrong: no pose has RefinementOptions::min_trusted_evidence, or a weak one
// is tilted against gravity (max_gravity_error_sigmas).
bool DoubtsGravity(const QueryContext& query, const PoseHypotheses& hypotheses,
                   const RefinementOptions& options, const PoseOptions& pose);

}  // namespace cairn

#endif  // CAIRN_ENGINE_REFINEMENT_MATCH_KEYFRAMES_H_
