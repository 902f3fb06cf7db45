// Updates of the filter from the tracks of features at unknown points: the multi-state constraint
// of Mourikis and Roumeliotis (2007).
#ifndef CAIRN_FUSION_TRACKS_TRACK_UPDATE_H_
#define CAIRN_FUSION_TRACKS_TRACK_UPDATE_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "fusion/filter/filter_state.h"
#include "fusion/tracks/track_table.h"
#include "fusion/tracks/triangulate.h"

namespace cairn::fusion {

struct TrackUpdateOptions {
  double sigma_px = 1.0;  // Standard deviation of a tracked pixel per axis.
  int min_views = 3;      // Two give one equation that outliers satisfy easily.
  // Longest tracks first; the rest of a frame's finished tracks is dropped. Bounds the time.
  int max_tracks = 60;
  // Gate on each track, as the quantile of a standard normal variable: 1.645 passes 95 % of true
  // tracks.
  double gate_quantile = 1.645;
  // Largest standard deviation of the way between a track's first and last sight, relative to that
  // way. A point triangulated on a baseline that is a guess is one, too: without this limit a
  // device that only turns, and by its inertial unit seems to move, grew sure of that motion.
  double max_relative_baseline_sigma = 0.5;
  TriangulateOptions triangulate;
  // Largest standard deviation of the distance of a point that enters the state, relative to it,
  // the errors of the poses counted. Beyond, the filter is overconfident (docs/math/fusion.md).
  double max_relative_point_sigma = 0.06;

  void Validate() const;
};

struct TrackUpdateCounts {
  int num_used = 0;
  int num_not_triangulated = 0;
  int num_gated = 0;  // Triangulated, but contradicting the state.
};

// A track whose sights are to be used.
struct FinishedTrack {
  uint64_t track_id = 0;
  bool goes_on = false;  // It is still in view: its point may enter the state.
  std::vector<Observation> sights;
  std::optional<MapDistance> map_distance;
};

// The 2 M rows of a track's M sights, and one more of the distance that the map knows, turned so
// that the first three alone touch the point.
struct TrackRows {
  Measurement clones;  // 2 M - 3 rows or one more, without the point.
  PointRows point;
};

// Nothing if the point cannot be found. `views[i]` belongs to clone i of `state`; `observations`
// are at clones. Before the alignment, and where the tile of the landmark is no longer in the
// state, `map_distance` is not used.
std::optional<TrackRows> LinearizeTrack(
    const FilterState& state, const Camera& camera, std::span<const CameraView> views,
    std::span<const Observation> observations, const TrackUpdateOptions& options,
    const std::optional<MapDistance>& map_distance = std::nullopt);

// The rows of all tracks without their points, compressed.
Measurement StackTracks(const FilterState& state, std::span<const TrackRows> tracks);

// Updates `state` with the given tracks, whose sights are at clones of `state`. The points of
// tracks that go on enter it where slots are free, those seen longest first.
TrackUpdateCounts UpdateFromTracks(const Camera& camera, std::vector<FinishedTrack> tracks,
                                   const TrackUpdateOptions& options, FilterState* state);

// The views of all clones, in their order.
std::vector<CameraView> ViewsOfClones(const FilterState& state);

// Index of the clone of a frame, or -1.
int FindClone(const FilterState& state, int64_t frame_id);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRACKS_TRACK_UPDATE_H_
