#include "fusion/tracks/finished_tracks.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

namespace cairn::fusion {

std::vector<FinishedTrack> TakeFinishedTracks(std::span<const Clone> clones, int max_clones,
                                              int min_views, TrackTable* tracks) {
  const int64_t frame_id = clones.back().frame_id;
  const int leaving = static_cast<int>(clones.size()) - max_clones - 1;
  const int64_t leaving_frame = leaving >= 0 ? clones[static_cast<size_t>(leaving)].frame_id : -1;
  const auto leaves = [leaving_frame](const Observation& observation) {
    return observation.frame_id == leaving_frame && !observation.reserved;
  };
  const auto is_due = [frame_id](const Observation& observation) {
    return !observation.reserved && observation.frame_id != frame_id;
  };
  std::vector<FinishedTrack> finished;
  for (Track& track : tracks->tracks()) {
    const bool goes_on = track.last_frame_id == frame_id;
    if (goes_on && std::none_of(track.observations.begin(), track.observations.end(), leaves)) {
      continue;
    }
    std::vector<Observation> observations;
    std::copy_if(track.observations.begin(), track.observations.end(),
                 std::back_inserter(observations), is_due);
    if (static_cast<int>(observations.size()) >= min_views) {
      std::erase_if(track.observations, is_due);
      finished.push_back({track.track_id, goes_on, std::move(observations),
                          std::exchange(track.map_distance, std::nullopt)});
    }
  }
  return finished;
}

}  // namespace cairn::fusion
