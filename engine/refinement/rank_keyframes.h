// Stage `refinement`: which mapping keyframes got more matches than chance (paper, section "Pose
// Candidate Refinement"; Gehrig et al. 2017).
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
  int num_votes = 0;  // Keypoints with a match among the landmarks that the keyframe saw.
  // n KL(x/n || p), with x the votes of the keyframe, n those of all keyframes and p the keyframe's
  // share of all observations: the Chernoff bound on minus the logarithm of the probability that
  // random matches give as many votes. Plus the logarithm of the GPS prior, -d^2 / (2 sigma^2).
  double log_score = 0.0;
};

// Keyframes with more votes than expected at random, highest score first, at most
// options.max_keyframes, of each location only the best (options.min_separation_m). A keypoint
// votes at most once for a keyframe; landmarks are recognised across tiles. The paper's p counts
// descriptors, ours observations, which is what a keyframe's share of random votes goes by here.
//
// Matches of a keypoint must be adjacent. Linear in the matches times the tiles, the sightings of
// their landmarks and the number of keyframes.
std::vector<RankedKeyframe> RankKeyframes(const QueryContext& query,
                                          const std::vector<TileView>& tiles,
                                          const std::vector<Correspondence>& correspondences,
                                          const RefinementOptions& options);

// The keyframe itself, then up to `num_neighbors` of those that share landmarks with it, most
// shared first, for re-matching. Looks among the keyframes within 50 m. Linear in the keyframe's
// landmarks times the tiles, their sightings and the number of keyframes.
std::vector<KeyframeRef> KeyframeNeighborhood(const std::vector<TileView>& tiles,
                                              const KeyframeRef& keyframe, int num_neighbors);

}  // namespace cairn

#endif  // CAIRN_ENGINE_REFINEMENT_RANK_KEYFRAMES_H_
