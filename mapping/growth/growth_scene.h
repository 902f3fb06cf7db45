// What the growth of segments knows about a set of photos, made once.
#ifndef CAIRN_MAPPING_GROWTH_GROWTH_SCENE_H_
#define CAIRN_MAPPING_GROWTH_GROWTH_SCENE_H_

#include <span>

#include "mapping/growth/draft.h"
#include "mapping/growth/grow_segments.h"
#include "mapping/growth/propose_photo.h"
#include "mapping/growth/view_graph.h"
#include "mapping/matching/two_view.h"
#include "mapping/photo_set.h"

namespace cairn {

// Keeps references to the arguments, and its members refer to each other. Immutable, and safe to
// use from several threads.
struct GrowthScene {
  GrowthScene(const PhotoSet& set, std::span<const TwoView> views, const GrowthOptions& options,
              const AdjustProgress& adjustment = {})
      : set(set),
        options(options),
        adjustment(adjustment),
        tracks(set, views),
        graph(set, views, options),
        proposer(set, graph, options) {}
  GrowthScene(const GrowthScene&) = delete;
  GrowthScene& operator=(const GrowthScene&) = delete;

  const PhotoSet& set;
  const GrowthOptions& options;
  const AdjustProgress adjustment;  // Of drafts that are adjusted as a whole.
  const TrackTable tracks;
  const ViewGraph graph;
  const Proposer proposer;
};

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_GROWTH_SCENE_H_
