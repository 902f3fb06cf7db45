#include "fusion/map_updates/observation_ledger.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion/filter/camera_view.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {
namespace {

void Append(const MapObservation& observation, const MapMatch& match,
            LedgerObservations* observations) {
  observations->observations.push_back(observation);
  observations->track_ids.push_back(match.track_id);
  observations->landmark_ids.push_back(match.landmark_id);
}

// Leaves with a track what its queried observation, just used, has not told of the landmark.
void NoteDistance(const MapObservation& observation, const FilterState& state, Track* track) {
  if (track->map_distance || !(observation.sigma_m > 0.0)) {
    return;
  }
  const Eigen::Vector3d center_in_local =
      CameraView(state.rig(), state.clones()[static_cast<size_t>(observation.clone)])
          .center_in_local;
  const Eigen::Vector3d ray =
      observation.x_in_global - *state.global_from_local() * center_in_local;
  track->map_distance = {observation.x_in_global, ray.normalized(), observation.sigma_m,
                         observation.tile_id};
}

}  // namespace

LedgerObservations ObservationLedger::ObservationsOf(std::span<const MapMatch> matches,
                                                     int64_t frame_id, const FilterState& state,
                                                     const TrackTable& tracks) const {
  LedgerObservations observations;
  int match_idx = 0;
  for (const MapMatch& match : matches) {
    MapObservation observation{match_idx,     FindClone(state, frame_id),
                               match.pixel,   match.x_in_global,
                               match.sigma_m, match.tile_id};
    observation.sigma_m *= std::sqrt(landmark_uses_.VarianceFactor(match.landmark_id));
    if (!match.track_id) {
      Append(observation, match, &observations);
    } else if (const Track* track = tracks.Find(*match.track_id)) {
      AppendTrack(*track, match, frame_id, observation, state, &observations);
    }
    ++match_idx;
  }
  return observations;
}

void ObservationLedger::AppendTrack(const Track& track, const MapMatch& match, int64_t frame_id,
                                    MapObservation at_clone, const FilterState& state,
                                    LedgerObservations* observations) const {
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
  const bool takes_others = LandmarkNoisePx(at_clone, state) * factor < sigma_px_;
  at_clone.pixel = queried->pixel;
  at_clone.sigma_m *= takes_others ? factor : 1.0;
  Append(at_clone, match, observations);
  for (const Observation& observation : track.observations) {
    if (takes_others && is_free(observation)) {
      at_clone.clone = FindClone(state, observation.frame_id);
      at_clone.pixel = observation.pixel;
      Append(at_clone, match, observations);
    }
  }
}

double ObservationLedger::LandmarkNoisePx(const MapObservation& observation,
                                          const FilterState& state) const {
  const auto& global_from_local = state.global_from_local();
  if (!global_from_local) {
    return std::numeric_limits<double>::infinity();
  }
  const Rigid3d& local_from_imu =
      state.clones()[static_cast<size_t>(observation.clone)].local_from_imu;
  const double distance_m =
      (*global_from_local * local_from_imu.translation - observation.x_in_global).norm();
  return camera_.focal_px() * observation.sigma_m / distance_m;
}

void ObservationLedger::TakeOut(const LedgerObservations& observations,
                                const std::vector<bool>& used, const FilterState& state,
                                TrackTable* tracks) {
  int last_match = -1;
  for (size_t i = 0; i < observations.observations.size(); ++i) {
    if (!used[i]) {
      continue;
    }
    const MapObservation& observation = observations.observations[i];
    Track* track = observations.track_ids[i] ? tracks->Find(*observations.track_ids[i]) : nullptr;
    if (observation.match != last_match) {
      last_match = observation.match;
      landmark_uses_.Add(observations.landmark_ids[i]);
      const bool alone = i + 1 == observations.observations.size() ||
                         observations.observations[i + 1].match != last_match;
      if (track != nullptr && alone) {
        NoteDistance(observation, state, track);
      }
    }
    if (track != nullptr) {
      const int64_t frame_id = state.clones()[static_cast<size_t>(observation.clone)].frame_id;
      std::erase_if(track->observations, [frame_id](const Observation& of_track) {
        return of_track.frame_id == frame_id;
      });
    }
  }
}

}  // namespace cairn::fusion
