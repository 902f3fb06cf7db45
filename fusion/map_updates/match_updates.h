// Updates a filter and its table of tracks from matches of the map.
#ifndef CAIRN_FUSION_MAP_UPDATES_MATCH_UPDATES_H_
#define CAIRN_FUSION_MAP_UPDATES_MATCH_UPDATES_H_

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "core/camera.h"
#include "core/rigid3.h"
#include "fusion/filter/filter_state.h"
#include "fusion/map_updates/map_match.h"
#include "fusion/map_updates/map_update.h"
#include "fusion/map_updates/observation_ledger.h"
#include "fusion/tracks/track_table.h"

namespace cairn::fusion {

// Runs UpdateFromMap and Align on the observations that an ObservationLedger gives for matches.
// Both calls remove the observations that they use from `tracks`. `frame_id` is the queried frame;
// it must have a clone in `state`. Not thread-safe.
class MatchUpdates {
 public:
  MatchUpdates(const Camera& camera, const MapUpdateOptions& options);

  // Updates `state`, which Align must have aligned. `state` and `tracks` change only if the status
  // is kApplied. In any case, landmarks regain the information that the state has lost since the
  // last answer.
  MapUpdateResult Update(std::span<const MapMatch> matches, int64_t frame_id, FilterState* state,
                         TrackTable* tracks);

  // Aligns `state`, starting from the global_from_local `initial`. Returns false and changes
  // nothing if too few matches fit.
  bool Align(std::span<const MapMatch> matches, int64_t frame_id, const Rigid3d& initial,
             FilterState* state, TrackTable* tracks);

  // Forgets which landmarks have been used. To be called when the state loses its alignment.
  void Clear() { ledger_.Clear(); }

 private:
  // Lets landmarks regain the information that the state has lost since the last answer.
  void ForgetUses(const FilterState& state);

  Camera camera_;
  MapUpdateOptions options_;
  ObservationLedger ledger_;
  Eigen::Matrix4d known_of_place_ = Eigen::Matrix4d::Zero();  // Covariance after the last answer.
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_MAP_UPDATES_MATCH_UPDATES_H_
