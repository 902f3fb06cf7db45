// Stage `refinement`: ranks the mapping keyframes that have more matches than chance explains
// (paper, section "Pose Candidate Refinement"; Gehrig et al. 2017).
#ifndef CAIRN_ENGINE_REFINEMENT_RANK_KEYFRAMES_H_
#define CAIRN_ENGINE_REFINEMENT_RANK_KEYFRAMES_H_

#include <vector>

#include "engine/matching/match_features.h"
#include "engine/query/query_context.h"
#include "engine/refinement/refinement_options.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

struct RankedKeyframe {
  KeyframeRef keyframe;
  int num_votes = 0;  // Number of keypoints with a match among the keyframe's landmarks.
  // n KL(x/n || p), plus the logarithm of the GPS prior, -d^2 / (2 sigma^2). x is the number of
  // votes for the keyframe, n that for all keyframes, and p the keyframe's share of all
  // observations. The first term is the Chernoff bound on minus the logarithm of the probability
  // that random matches give as many votes.
  double log_score = 0.0;
};

// Returns the keyframes with more votes than random matches would give, highest score first, at
// most options.max_keyframes. Of each location, only the best keyframe is returned
// (options.min_separation_m). A keypoint votes at most once for a keyframe. Landmarks are
// recognized across tiles. The paper's p counts descriptors; this p counts observations, because a
// keyframe's share of random votes here is its share of observations.
//
// Matches of a keypoint must be adjacent. Takes time linear in the number of matches times the
// number of tiles, the observations of their landmarks, and the number of keyframes.
std::vector<RankedKeyframe> RankKeyframes(const QueryContext& query,
                                          const std::vector<TileView>& tiles,
                                          const std::vector<Correspondence>& correspondences,
                                          const RefinementOptions& options);

// Returns the keyframe itself, then up to `num_neighbors` keyframes that share the most landmarks
// with it, for re-matching. Searches among the keyframes within 50 m. Takes time linear in the
// number of the keyframe's landmarks times the number of tiles, the observations of these
// landmarks, and the number of keyframes.
std::vector<KeyframeRef> KeyframeNeighborhood(const std::vector<TileView>& tiles,
                                              const KeyframeRef& keyframe, int num_neighbors);

}  // namespace cairn

#endif  // CAIRN_ENGINE_REFINEMENT_RANK_KEYFRAMES_H_
