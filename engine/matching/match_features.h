// Stage `matching`: 2D-3D correspondences of a query against tiles.
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

// The k best landmarks of each keypoint over all tiles that pass the filters; a landmark that lies
// in several tiles counts once (its nearest copy). Ordered by keypoint, then distance, then
// landmark id. Sets the matching counters. Throws Error(kInternal) unless all tiles share the
// codebook that the query's descriptors were projected with (checked by id among the tiles, by
// dimension with the query). `workers` (may be null) share the work, by ranges of keypoints; the
// result is the same. When `should_stop` says so, what has been found by then is all.
std::vector<Correspondence> MatchFeatures(const QueryContext& query,
                                          const std::vector<TileView>& tiles,
                                          const MatchingOptions& options, StageCounters* counters,
                                          SharedWorkers* workers = nullptr,
                                          const StopFunction& should_stop = {});

// For the refinement stage: matches all keypoints against just the landmarks that the given
// keyframes saw, exhaustively, with the absolute threshold at `distance_quantile`
// whatever the distance filter. Keyframes may repeat.
// Same order and rules as MatchFeatures.
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
