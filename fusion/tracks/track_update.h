// Updates the filter from tracks of features at unknown points: the multi-state constraint of
// Mourikis and Roumeliotis (2007).
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

// Fewest observations of a track. Two views give one equation, which outliers satisfy easily.
inline constexpr int kMinTrackViews = 3;
// Gate on each track, given as a quantile of the standard normal distribution; passes 95 % of the
// true tracks.
inline constexpr double kTrackGateQuantile = 1.645;

struct TrackUpdateOptions {
  double sigma_px = 1.0;  // Standard deviation of a tracked pixel per axis.
  // Most tracks per update, which bounds the time. The longest tracks are used; the rest of a
  // frame's finished tracks is dropped.
  int max_tracks = 60;
  TriangulateOptions triangulate;

  void Validate() const;
};

struct TrackUpdateCounts {
  int num_used = 0;
  int num_not_triangulated = 0;
  int num_gated = 0;  // Triangulated, but contradicting the state.
};

// A track whose observations the next update uses.
struct FinishedTrack {
  uint64_t track_id = 0;
  bool goes_on = false;  // Still in view, so its point may enter the state.
  std::vector<Observation> observations;
  std::optional<MapDistance> map_distance;
};

// The linearized rows of a track with M observations: 2 M rows, plus one if the map knows the
// distance. An orthogonal transformation confines the point to the first three rows.
struct TrackRows {
  Measurement clones;  // 2 M - 3 rows, or one more, without the point.
  PointRows point;
};

// Linearizes a track. `views[i]` belongs to clone i of `state`, and every observation is at a
// clone. Ignores `map_distance` before the alignment and if the landmark's tile is no longer in the
// state. Returns nullopt if the point cannot be triangulated.
std::optional<TrackRows> LinearizeTrack(
    const FilterState& state, const Camera& camera, std::span<const CameraView> views,
    std::span<const Observation> observations, const TrackUpdateOptions& options,
    const std::optional<MapDistance>& map_distance = std::nullopt);

// Stacks the rows of all tracks, without their points, and compresses the result.
Measurement StackTracks(const FilterState& state, std::span<const TrackRows> tracks);

// Updates `state` with the given tracks, whose observations are all at clones of `state`. If slots
// are free, the points of tracks that go on enter the state, longest tracks first.
TrackUpdateCounts UpdateFromTracks(const Camera& camera, std::vector<FinishedTrack> tracks,
                                   const TrackUpdateOptions& options, FilterState* state);

// The views of all clones, in the order of the clones.
std::vector<CameraView> ViewsOfClones(const FilterState& state);

// Returns the index of the clone of a frame, or -1.
int FindClone(const FilterState& state, int64_t frame_id);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRACKS_TRACK_UPDATE_H_
