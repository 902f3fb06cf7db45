#include "fusion/tracks/point_update.h"

#include <optional>
#include <utility>
#include <vector>

#include "fusion/filter/camera_view.h"
#include "fusion/filter/chi_square.h"

namespace cairn::fusion {
namespace {

// Linearizes one observation as two rows. Returns nullopt if the point does not project into the
// image.
std::optional<Measurement> LinearizeObservationOfPoint(const FilterState& state,
                                                       const Camera& camera,
                                                       std::span<const CameraView> views, int slot,
                                                       const Observation& observation,
                                                       double sigma_px) {
  const StatePoint& point = *state.points()[static_cast<size_t>(slot)];
  const int clone = FindClone(state, observation.frame_id);
  if (clone < 0) {
    return std::nullopt;
  }
  const CameraView& view = views[static_cast<size_t>(clone)];
  const LocatedPoint located = state.Locate(slot);
  const auto predicted = PredictPixel(camera, view, located.x_in_local);
  const auto first = PredictPixel(camera, view, located.first_x_in_local);
  if (!predicted || !first) {
    return std::nullopt;
  }
  const int rig_dims = state.estimates_rig() ? kRigDim : 0;
  Measurement measurement;
  measurement.blocks = {{state.CloneIdx(clone), kCloneDim},
                        {state.CloneIdx(point.anchor), kCloneDim},
                        {state.PointIdx(slot), kPointDim}};
  measurement.jacobian.resize(2, 2 * kCloneDim + kPointDim + rig_dims);
  measurement.jacobian.leftCols<kCloneDim>() = ByClone(*first, view, located.first_x_in_local);
  measurement.jacobian.middleCols<kCloneDim>(kCloneDim) = first->by_local * located.by_anchor;
  measurement.jacobian.middleCols<kPointDim>(2 * kCloneDim) =
      first->by_local * located.by_coordinates;
  if (rig_dims > 0) {
    measurement.blocks.push_back({kRigIdx, kRigDim});
    measurement.jacobian.rightCols<kRigDim>() = ByRig(*first, state.rig());
  }
  measurement.jacobian /= sigma_px;
  measurement.residual = (observation.pixel - predicted->pixel) / sigma_px;
  return measurement;
}

// Removes the unreserved observations from a track and returns them.
std::vector<Observation> TakeFreeObservations(Track* track) {
  std::vector<Observation> observations;
  std::erase_if(track->observations, [&observations](const Observation& observation) {
    if (!observation.reserved) {
      observations.push_back(observation);
    }
    return !observation.reserved;
  });
  return observations;
}

}  // namespace

PointUpdateCounts UpdateFromPoints(const Camera& camera, int64_t frame_id,
                                   const TrackUpdateOptions& options, TrackTable* tracks,
                                   FilterState* state) {
  PointUpdateCounts counts;
  const std::vector<CameraView> views = ViewsOfClones(*state);
  const double gate = ChiSquareQuantile(2, kTrackGateQuantile);
  std::vector<Measurement> accepted;
  std::vector<int> dropped;
  for (int slot = 0; slot < static_cast<int>(state->points().size()); ++slot) {
    const auto& point = state->points()[static_cast<size_t>(slot)];
    Track* track = point ? tracks->Find(point->track_id) : nullptr;
    if (point && (track == nullptr || track->last_frame_id != frame_id)) {
      state->RemovePoint(slot);
      continue;
    }
    for (const Observation& observation :
         point ? TakeFreeObservations(track) : std::vector<Observation>()) {
      auto measurement =
          LinearizeObservationOfPoint(*state, camera, views, slot, observation, options.sigma_px);
      const bool fits = measurement && state->SquaredMahalanobis(*measurement) < gate;
      if (fits) {
        accepted.push_back(std::move(*measurement));
      } else if (point->contradicted) {
        dropped.push_back(slot);
      }
      counts.num_gated += fits ? 0 : 1;
      state->SetContradicted(slot, !fits);
    }
  }
  counts.num_used = static_cast<int>(accepted.size());
  state->Update(accepted);
  for (const int slot : dropped) {
    state->RemovePoint(slot);
  }
  return counts;
}

}  // namespace cairn::fusion
