// What a camera that turns but does not move says about the way: that it is short.
//
// Points whose sights differ by a rotation alone have no depth, so their tracks are of no use, and
// the position would be that of the inertial unit alone, metres off within seconds. But unless
// everything in view is far away, the device has not gone far.
#ifndef CAIRN_FUSION_TRACKS_ROTATION_ONLY_H_
#define CAIRN_FUSION_TRACKS_ROTATION_ONLY_H_

#include <optional>

#include "core/camera.h"
#include "fusion/filter/filter_state.h"
#include "fusion/tracks/track_table.h"

namespace cairn::fusion {

struct RotationOnlyOptions {
  // Distance within which half of what is in view stands. A bound, not an estimate.
  double median_distance_m = 20.0;
  int min_tracks = 15;
  double gate_quantile = 3.09;  // Passes 99.9 %.

  void Validate() const;
};

// Median over the tracks seen at both clones of the distance in pixels between the sight at `to`
// and the sight at `from` turned there; nothing with fewer than options.min_tracks.
std::optional<double> MedianParallaxPx(const FilterState& state, const Camera& camera,
                                       const TrackTable& tracks, int from, int to,
                                       const RotationOnlyOptions& options);

// "From clone `from` to clone `to` the device went nowhere, but for the way that this parallax is
// at median_distance_m." Nothing if that says less than the state knows.
std::optional<Measurement> RotationOnlyMeasurement(const FilterState& state, const Camera& camera,
                                                   double parallax_px, int from, int to,
                                                   const RotationOnlyOptions& options);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRACKS_ROTATION_ONLY_H_
