#include "fusion/map_updates/sight_ledger.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion/filter/camera_view.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {
namespace {

void Append(const MapSight& sight, const MapMatch& match, LedgerSights* sights) {
  sights->sights.push_back(sight);
  sights->track_ids.push_back(match.track_id);
  sights->landmark_ids.push_back(match.landmark_id);
}

// Leaves with a track what its queried sight, just used, has not told of the landmark.
void NoteDistance(const MapSight& sight, const FilterState& state, Track* track) {
  if (track->map_distance || !(sight.sigma_m > 0.0)) {
    return;
  }
  const Eigen::Vector3d center_in_local =
      CameraView(state.rig(), state.clones()[static_cast<size_t>(sight.clone)]).center_in_local;
  const Eigen::Vector3d ray = sight.x_in_global - *state.global_from_local() * center_in_local;
  track->map_distance = {sight.x_in_global, ray.normalized(), sight.sigma_m, sight.tile_id};
}

}  // namespace

LedgerSights SightLedger::SightsOf(std::span<const MapMatch> matches, int64_t frame_id,
                                   const FilterState& state, const TrackTable& tracks) const {
  LedgerSights sights;
  int match_idx = 0;
  for (const MapMatch& match : matches) {
    MapSight sight{match_idx,     FindClone(state, frame_id),
                   match.pixel,   match.x_in_global,
                   match.sigma_m, match.tile_id};
    sight.sigma_m *= std::sqrt(landmark_uses_.VarianceFactor(match.landmark_id));
    if (!match.track_id) {
      Append(sight, match, &sights);
    } else if (const Track* track = tracks.Find(*match.track_id)) {
      AppendTrack(*track, match, frame_id, sight, state, &sights);
    }
    ++match_idx;
  }
  return sights;
}

void SightLedger::AppendTrack(const Track& track, const MapMatch& match, int64_t frame_id,
                              MapSight sight, const FilterState& state,
                              LedgerSights* sights) const {
  const auto queried = std::find_if(
      track.observations.begin(), track.observations.end(),
      [frame_id](const Observation& observation) { return observation.frame_id == frame_id; });
  if (queried == track.observations.end()) {
    return;  // It has been used.
  }
  const auto is_free = [&](const Observation& observation) {
    return !observation.reserved && observation.frame_id != frame_id &&
           FindClone(state, observation.frame_id) >= 0;
  };
  const auto num_others =
      std::count_if(track.observations.begin(), track.observations.end(), is_free);
  const double factor = std::sqrt(static_cast<double>(1 + num_others));
  const bool takes_others = LandmarkNoisePx(sight, state) * factor < sigma_px_;
  sight.pixel = queried->pixel;
  sight.sigma_m *= takes_others ? factor : 1.0;
  Append(sight, match, sights);
  for (const Observation& observation : track.observations) {
    if (takes_others && is_free(observation)) {
      sight.clone = FindClone(state, observation.frame_id);
      sight.pixel = observation.pixel;
      Append(sight, match, sights);
    }
  }
}

double SightLedger::LandmarkNoisePx(const MapSight& sight, const FilterState& state) const {
  const auto& global_from_local = state.global_from_local();
  if (!global_from_local) {
    return std::numeric_limits<double>::infinity();
  }
  const Rigid3d& local_from_imu = state.clones()[static_cast<size_t>(sight.clone)].local_from_imu;
  const double distance_m =
      (*global_from_local * local_from_imu.translation - sight.x_in_global).norm();
  return camera_.focal_px() * sight.sigma_m / distance_m;
}

void SightLedger::TakeOut(const LedgerSights& sights, const std::vector<bool>& used,
                          const FilterState& state, TrackTable* tracks) {
  int last_match = -1;
  for (size_t i = 0; i < sights.sights.size(); ++i) {
    if (!used[i]) {
      continue;
    }
    const MapSight& sight = sights.sights[i];
    Track* track = sights.track_ids[i] ? tracks->Find(*sights.track_ids[i]) : nullptr;
    if (sight.match != last_match) {
      last_match = sight.match;
      landmark_uses_.Add(sights.landmark_ids[i]);
      const bool alone = i + 1 == sights.sights.size() || sights.sights[i + 1].match != last_match;
      if (track != nullptr && alone) {
        NoteDistance(sight, state, track);
      }
    }
    if (track != nullptr) {
      const int64_t frame_id = state.clones()[static_cast<size_t>(sight.clone)].frame_id;
      std::erase_if(track->observations, [frame_id](const Observation& observation) {
        return observation.frame_id == frame_id;
      });
    }
  }
}

}  // namespace cairn::fusion
