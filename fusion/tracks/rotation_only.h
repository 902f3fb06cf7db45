// Bounds the distance moved by a camera that turns in place.
//
// If the observations of a point differ by a rotation alone, the point has no depth, so tracks do
// not help. The position would then come from the IMU alone and drift by meters within seconds. But
// unless everything in view is far away, a device whose images show only rotation has moved little.
#ifndef CAIRN_FUSION_TRACKS_ROTATION_ONLY_H_
#define CAIRN_FUSION_TRACKS_ROTATION_ONLY_H_

#include <cstdint>
#include <optional>

#include "core/camera.h"
#include "fusion/filter/filter_state.h"
#include "fusion/tracks/track_table.h"

namespace cairn::fusion {

// For each track that both clones see, turns the observation at `from` into the orientation of `to`
// and takes its distance in pixels to the observation at `to`. Returns the median of these
// distances, or nullopt if there are fewer than 15 such tracks.
std::optional<double> MedianParallaxPx(const FilterState& state, const Camera& camera,
                                       const TrackTable& tracks, int from, int to);

// Returns the measurement "the position did not change from clone `from` to clone `to`". Its
// standard deviation is the motion that causes `parallax_px` at a distance of 20 m. Returns nullopt
// if the state already knows the motion better.
std::optional<Measurement> RotationOnlyMeasurement(const FilterState& state, const Camera& camera,
                                                   double parallax_px, int from, int to);

// Applies RotationOnlyMeasurement to one filter. Each update starts where the last one ended, so
// that no information is used twice, and spans at least half of a window of `max_clones`. Not
// thread-safe.
class RotationOnlyUpdates {
 public:
  RotationOnlyUpdates(const Camera& camera, int max_clones)
      : camera_(camera), max_clones_(max_clones) {}

  // Updates `state`, which must have a clone, if the camera has only turned. Returns whether it
  // did.
  bool Update(const TrackTable& tracks, FilterState* state);

 private:
  Camera camera_;
  int max_clones_;
  int64_t last_update_ns_ = 0;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRACKS_ROTATION_ONLY_H_
