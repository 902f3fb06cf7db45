// Selects the observations that are due for an update.
#ifndef CAIRN_FUSION_TRACKS_FINISHED_TRACKS_H_
#define CAIRN_FUSION_TRACKS_FINISHED_TRACKS_H_

#include <span>
#include <vector>

#include "fusion/filter/filter_state.h"
#include "fusion/tracks/track_table.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {

// Removes from `tracks` and returns the free observations of the tracks that are due. The newest
// frame is that of the last of `clones`. A track is due if the newest frame does not see it, or if
// it has a free observation at the clone that is about to leave a window of `max_clones`. Tracks
// with fewer than `min_views` free observations before the newest frame are left as they are. The
// newest observation of a track that goes on stays in the table: it starts the track's next part,
// and it may be queried.
std::vector<FinishedTrack> TakeFinishedTracks(std::span<const Clone> clones, int max_clones,
                                              int min_views, TrackTable* tracks);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRACKS_FINISHED_TRACKS_H_
