#include "fusion/map_updates/match_updates.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

#include "fusion/filter/pose_covariance.h"
#include "fusion/map_updates/alignment.h"

namespace cairn::fusion {
namespace {

// Of yaw and position of the newest clone's camera in global.
Eigen::Matrix4d PlaceCovariance(const FilterState& state) {
  const int newest = static_cast<int>(state.clones().size()) - 1;
  return CameraPrior(state, newest).covariance.bottomRightCorner<4, 4>();
}

}  // namespace

MatchUpdates::MatchUpdates(const Camera& camera, const MapUpdateOptions& options)
    : camera_(camera), options_(options), ledger_(camera, options.sigma_px) {}

void MatchUpdates::ForgetUses(const FilterState& state) {
  // Of each direction's information, the mean share that is left.
  const Eigen::Matrix4d now = PlaceCovariance(state);
  ledger_.ForgetLandmarks(std::clamp(now.ldlt().solve(known_of_place_).trace() / 4.0, 0.0, 1.0));
}

MapUpdateResult MatchUpdates::Update(std::span<const MapMatch> matches, int64_t frame_id,
                                     FilterState* state, TrackTable* tracks) {
  ForgetUses(*state);
  const LedgerObservations observations =
      ledger_.ObservationsOf(matches, frame_id, *state, *tracks);
  const MapUpdateResult result = UpdateFromMap(camera_, observations.observations, options_, state);
  if (result.status == MapUpdateStatus::kApplied) {
    ledger_.TakeOut(observations, result.used_observations, *state, tracks);
  }
  known_of_place_ = PlaceCovariance(*state);
  return result;
}

bool MatchUpdates::Align(std::span<const MapMatch> matches, int64_t frame_id,
                         const Rigid3d& initial, FilterState* state, TrackTable* tracks) {
  const LedgerObservations observations =
      ledger_.ObservationsOf(matches, frame_id, *state, *tracks);
  if (!fusion::Align(camera_, observations.observations, initial, options_, state)) {
    return false;
  }
  ledger_.TakeOut(observations, std::vector<bool>(observations.observations.size(), true), *state,
                  tracks);
  known_of_place_ = PlaceCovariance(*state);
  return true;
}

}  // namespace cairn::fusion
