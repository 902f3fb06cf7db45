// Updates of the filter from the tracks of features at unknown points: the multi-state constraint
// of Mourikis and Roumeliotis (2007).
#ifndef CAIRN_FUSION_TRACK_UPDATE_H_
#define CAIRN_FUSION_TRACK_UPDATE_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "fusion/filter_state.h"
#include "fusion/track_table.h"
#include "fusion/triangulate.h"

namespace cairn::fusion {

struct TrackUpdateOptions {
  double sigma_px = 1.0;  // Standard deviation of a tracked pixel per axis.
  int min_views = 3;      // Two give one equation that outliers satisfy easily.
  // Longest tracks first; the rest of a frame's finished tracks is dropped. Bounds the time.
  int max_tracks = 40;
  // Gate on each track, as the quantile of a standard normal variable: 1.645 passes 95 % of true
  // tracks.
  double gate_quantile = 1.645;
  TriangulateOptions triangulate;

  void Validate() const;
};

struct TrackUpdateCounts {
  int num_used = 0;
  int num_not_triangulated = 0;
  int num_gated = 0;  // Triangulated, but contradicting the state.
};

// The residuals of a track's sights with the point eliminated: 2 M - 3 rows from M sights. Nothing
// if the point cannot be found. `views[i]` belongs to clone i of `state`; `observations` are at
// clones.
std::optional<Measurement> TrackMeasurement(const FilterState& state, const Camera& camera,
                                            std::span<const CameraView> views,
                                            std::span<const Observation> observations,
                                            const TrackUpdateOptions& options);

// Updates `state` with the given tracks, each a list of sights at clones of `state`.
TrackUpdateCounts UpdateFromTracks(const Camera& camera,
                                   std::vector<std::vector<Observation>> tracks,
                                   const TrackUpdateOptions& options, FilterState* state);

// The views of all clones, in their order.
std::vector<CameraView> ViewsOfClones(const FilterState& state);

// Index of the clone of a frame, or -1.
int FindClone(const FilterState& state, int64_t frame_id);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRACK_UPDATE_H_
