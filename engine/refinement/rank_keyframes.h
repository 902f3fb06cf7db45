// Stage `refinement`: which mapping keyframes got more matches than chance (paper, section "Pose
// Candidate Refinement"; Gehrig et al. 2017).
#ifndef CAIRN_ENGINE_REFINEMENT_RANK_KEYFRAMES_H_
#define CAIRN_ENGINE_REFINEMENT_RANK_KEYFRAMES_H_

#include <vector>

#include "engine/matching/match_features.h"
#include "engine/query_context.h"
#include "engine/refinement/refinement_options.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

struct RankedKeyframe {
  KeyframeRef keyframe;
  int num_votes = 0;
  double log_score = 0.0;  // n KL(x/n || p) of the binomial tail, plus the log of the GPS prior.
};

// Keyframes with more votes than expected at random, highest score first, at most
// options.max_keyframes. A keypoint votes at most once for a keyframe.
std::vector<RankedKeyframe> RankKeyframes(const QueryContext& query,
                                          const std::vector<TileView>& tiles,
                                          const std::vector<Correspondence>& correspondences,
                                          const RefinementOptions& options);

// The keyframe and those that share most landmarks with it, for re-matching.
std::vector<KeyframeRef> KeyframeNeighborhood(const std::vector<TileView>& tiles,
                                              const KeyframeRef& keyframe, int num_neighbors);

}  // namespace cairn

#endif  // CAIRN_ENGINE_REFINEMENT_RANK_KEYFRAMES_H_
