// Updates the filter while the device stands still.
#ifndef CAIRN_FUSION_START_STANDSTILL_UPDATES_H_
#define CAIRN_FUSION_START_STANDSTILL_UPDATES_H_

#include <cstdint>
#include <optional>

#include "core/inertial/imu_buffer.h"
#include "fusion/filter/filter_state.h"
#include "fusion/start/standstill.h"
#include "fusion/tracks/track_table.h"

namespace cairn::fusion {

struct StandstillUpdate {
  bool is_still = false;  // Whether the filter has been updated.
  // The frame before the newest one, if its clone may be removed because the device has been at
  // rest since an earlier frame. The window then keeps older views instead of many views of one
  // place.
  std::optional<int64_t> redundant_frame_id;
};

// Applies StandstillMeasurement to one filter, against the frame in which the device came to rest.
// Not thread-safe.
class StandstillUpdates {
 public:
  explicit StandstillUpdates(const StandstillOptions& options) : options_(options) {}

  // Updates `state` if the device is at rest at the newest clone. The device is at rest if the
  // readings of the last options.window_s are quiet, the tracks have not moved since it came to
  // rest, and the state does not contradict this. `tracks` must have the observations of the newest
  // clone.
  StandstillUpdate Update(const ImuBuffer& imu, const TrackTable& tracks, FilterState* state);

 private:
  StandstillOptions options_;
  std::optional<int64_t> anchor_frame_id_;  // The frame in which the device came to rest.
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_START_STANDSTILL_UPDATES_H_
