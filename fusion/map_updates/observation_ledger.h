// Decides which observations an answer of the map may use, so that no observation counts twice.
#ifndef CAIRN_FUSION_MAP_UPDATES_OBSERVATION_LEDGER_H_
#define CAIRN_FUSION_MAP_UPDATES_OBSERVATION_LEDGER_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "fusion/filter/filter_state.h"
#include "fusion/map_updates/landmark_uses.h"
#include "fusion/map_updates/map_match.h"
#include "fusion/map_updates/map_update.h"
#include "fusion/tracks/track_table.h"

namespace cairn::fusion {

// Observations for one update. The vectors are parallel.
struct LedgerObservations {
  std::vector<MapObservation> observations;
  std::vector<std::optional<uint64_t>> track_ids;  // The track that an observation belongs to.
  std::vector<uint64_t> landmark_ids;
};

// An observation of a track is free, reserved for the answer to a query, or used. A used
// observation is no longer in the TrackTable. The ledger turns matches into observations that an
// update may use. After the update, the ledger removes the used observations from the table. It
// also counts how much of each landmark's information the state has used (LandmarkUses). Not
// thread-safe.
class ObservationLedger {
 public:
  // `sigma_px` is the standard deviation of a matched keypoint per axis.
  ObservationLedger(const Camera& camera, double sigma_px) : camera_(camera), sigma_px_(sigma_px) {}

  // Returns the observations for an answer about the frame `frame_id`, which must have a clone in
  // `state`.
  // - A match without a track gives one observation, the queried one.
  // - A match with a track also gives the track's free observations at other clones, if `state` is
  //   aligned and the landmark is known so well that pixel noise limits the information of one
  //   observation. The sigma of each observation is then larger, as MapObservation::sigma_m says.
  // - A match gives nothing if its track's observation in the frame has been used.
  LedgerObservations ObservationsOf(std::span<const MapMatch> matches, int64_t frame_id,
                                    const FilterState& state, const TrackTable& tracks) const;

  // Records that observation i has been used, for each i with used[i]: removes the observation from
  // `tracks` and counts a use of the landmark. If the queried observation alone was used, the
  // landmark's distance has not been used; the track keeps it as map_distance. `state` must be
  // aligned and must have the clones that it had for ObservationsOf.
  void TakeOut(const LedgerObservations& observations, const std::vector<bool>& used,
               const FilterState& state, TrackTable* tracks);

  // See LandmarkUses::Forget.
  void ForgetLandmarks(double share_kept) { landmark_uses_.Forget(share_kept); }

  // Forgets all uses of landmarks.
  void Clear() { landmark_uses_.Clear(); }

 private:
  void AppendTrack(const Track& track, const MapMatch& match, int64_t frame_id,
                   MapObservation observation, const FilterState& state,
                   LedgerObservations* observations) const;
  // Size in the image of the error of an observation's landmark; infinite before the alignment.
  double LandmarkNoisePx(const MapObservation& observation, const FilterState& state) const;

  Camera camera_;
  double sigma_px_;
  LandmarkUses landmark_uses_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_MAP_UPDATES_OBSERVATION_LEDGER_H_
