// Updates the filter from observations of the long-lived points in its state.
#ifndef CAIRN_FUSION_TRACKS_POINT_UPDATE_H_
#define CAIRN_FUSION_TRACKS_POINT_UPDATE_H_

#include <cstdint>
#include <span>

#include "core/camera.h"
#include "fusion/filter/filter_state.h"
#include "fusion/tracks/track_table.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {

struct PointUpdateCounts {
  int num_used = 0;   // Observations that were applied.
  int num_gated = 0;  // Observations that contradict the state.
};

// Applies the unreserved observations of the points' tracks and removes these observations from
// `tracks`. A point leaves the state if the newest frame, `frame_id`, did not see it, or if two
// consecutive observations of it contradict the state.
PointUpdateCounts UpdateFromPoints(const Camera& camera, int64_t frame_id,
                                   const TrackUpdateOptions& options, TrackTable* tracks,
                                   FilterState* state);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRACKS_POINT_UPDATE_H_
