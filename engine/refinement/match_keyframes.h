// Stage `refinement`: matches the query again, against the landmarks of single keyframes.
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

// Returns true if the poses found so far need refinement; see RefinementOptions::mode.
bool NeedsRefinement(const PoseHypotheses& hypotheses, const RefinementOptions& options);

// A query and its matches with tiles. Refers to its parts.
struct MatchedQuery {
  const QueryContext& query;
  const std::vector<TileView>& tiles;
  const SharedMatches& matches;
};

// What the stage uses of the localizer's options, which must outlive the object.
struct KeyframeMatching {
  const RefinementOptions& refinement;
  const MatchingOptions& matching;
  const PoseOptions& pose;
  uint64_t seed;
};

struct KeyframePoses {
  TriedPoses tried;  // An attempt is a keyframe.
  int64_t num_rematches = 0;
};

// Matches the query against two kinds of keyframes, each with its neighbors: those that saw most
// of what the best poses explain, and those with the most matches. A keyframe that was matched as a
// neighbor of an earlier one is left out. Estimates a pose from each and adds the poses to
// `hypotheses`.
KeyframePoses MatchKeyframes(const MatchedQuery& matched, const KeyframeMatching& options,
                             const QueryBudget& budget, PoseHypotheses hypotheses);

// Returns true if gravity may be wrong: no pose has RefinementOptions::min_trusted_evidence, or the
// best pose is weak and tilted against gravity (max_gravity_error_sigmas).
bool DoubtsGravity(const QueryContext& query, const PoseHypotheses& hypotheses,
                   const RefinementOptions& options, const PoseOptions& pose);

}  // namespace cairn

#endif  // CAIRN_ENGINE_REFINEMENT_MATCH_KEYFRAMES_H_
