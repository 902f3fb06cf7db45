// Stage `matching`: finds 2D-3D correspondences between a query and tiles.
#ifndef CAIRN_ENGINE_MATCHING_MATCH_FEATURES_H_
#define CAIRN_ENGINE_MATCHING_MATCH_FEATURES_H_

#include <vector>

#include "core/shared_workers.h"
#include "core/stop_function.h"
#include "engine/matching/matching_options.h"
#include "engine/query/localize_result.h"
#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// For each keypoint, returns the k best landmarks over all tiles that pass the filters. A landmark
// in several tiles counts once (its nearest copy). Results are ordered by keypoint, then distance,
// then landmark id. Sets the matching counters. `workers` (may be null) share the work by ranges of
// keypoints; the result does not depend on them. Polls `should_stop`; once it returns true, the
// search ends with the correspondences found so far. Throws Error(kInternal) unless all tiles share
// the codebook with which the query's descriptors were projected. The check compares codebook ids
// among the tiles, and the dimension with the query.
std::vector<Correspondence> MatchFeatures(const QueryContext& query,
                                          const std::vector<TileView>& tiles,
                                          const MatchingOptions& options, StageCounters* counters,
                                          SharedWorkers* workers = nullptr,
                                          const StopFunction& should_stop = {});

// Matches all keypoints against only the landmarks that the given keyframes saw, for the refinement
// stage. The search is exhaustive, with the absolute threshold at `distance_quantile` whatever the
// distance filter. Keyframes may repeat. Order and rules are those of MatchFeatures.
struct KeyframeRef {
  int tile_idx = 0;
  uint32_t keyframe_idx = 0;

  bool operator==(const KeyframeRef&) const = default;
};
std::vector<Correspondence> MatchAgainstKeyframes(const QueryContext& query,
                                                  const std::vector<TileView>& tiles,
                                                  const std::vector<KeyframeRef>& keyframes,
                                                  double distance_quantile,
                                                  const MatchingOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_MATCH_FEATURES_H_
