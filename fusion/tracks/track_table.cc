#include "fusion/tracks/track_table.h"

#include <algorithm>

namespace cairn::fusion {

TrackTable::TrackTable(int max_tracks) : max_tracks_(static_cast<size_t>(max_tracks)) {
  tracks_.reserve(max_tracks_);
  index_.reserve(max_tracks_);
}

int TrackTable::AddFrame(int64_t frame_id, const Camera& camera,
                         std::span<const TrackedFeature> features) {
  int num_entered = 0;
  for (const TrackedFeature& feature : features) {
    const auto ray = feature.pixel.allFinite() ? camera.Unproject(feature.pixel) : std::nullopt;
    if (!ray || !(ray->z() > 0.05)) {
      continue;
    }
    Track* track = Find(feature.track_id);
    if (track == nullptr) {
      if (tracks_.size() == max_tracks_) {
        continue;
      }
      index_.emplace(feature.track_id, tracks_.size());
      track = &tracks_.emplace_back();
      track->track_id = feature.track_id;
    } else if (track->last_frame_id == frame_id) {
      continue;
    }
    track->last_frame_id = frame_id;
    track->observations.push_back({frame_id, feature.pixel, *ray, false});
    ++num_entered;
  }
  return num_entered;
}

Track* TrackTable::Find(uint64_t track_id) {
  const auto found = index_.find(track_id);
  return found == index_.end() ? nullptr : &tracks_[found->second];
}

const Track* TrackTable::Find(uint64_t track_id) const {
  const auto found = index_.find(track_id);
  return found == index_.end() ? nullptr : &tracks_[found->second];
}

void TrackTable::SetReserved(int64_t frame_id, bool reserved) {
  for (Track& track : tracks_) {
    for (Observation& observation : track.observations) {
      if (observation.frame_id == frame_id) {
        observation.reserved = reserved;
      }
    }
  }
}

void TrackTable::DropFrame(int64_t frame_id) {
  for (Track& track : tracks_) {
    std::erase_if(track.observations, [frame_id](const Observation& observation) {
      return observation.frame_id == frame_id;
    });
  }
}

void TrackTable::DropFinished(int64_t frame_id) {
  const size_t num_erased = std::erase_if(tracks_, [frame_id](const Track& track) {
    const bool reserved =
        std::any_of(track.observations.begin(), track.observations.end(),
                    [](const Observation& observation) { return observation.reserved; });
    return track.last_frame_id != frame_id && !reserved;
  });
  if (num_erased > 0) {
    RebuildIndex();
  }
}

void TrackTable::Clear() {
  tracks_.clear();
  index_.clear();
}

void TrackTable::RebuildIndex() {
  index_.clear();
  for (size_t i = 0; i < tracks_.size(); ++i) {
    index_.emplace(tracks_[i].track_id, i);
  }
}

}  // namespace cairn::fusion
