#include "fusion/start/standstill_updates.h"

#include <utility>

#include "core/inertial/imu_time.h"
#include "fusion/filter/chi_square.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {

StandstillUpdate StandstillUpdates::Update(const ImuBuffer& imu, const TrackTable& tracks,
                                           FilterState* state) {
  const auto& clones = state->clones();
  const std::optional<int64_t> last_anchor = std::exchange(anchor_frame_id_, std::nullopt);
  if (clones.size() < 2) {
    return {};
  }
  const int64_t now_ns = clones.back().timestamp_ns;
  const int64_t begin_ns = now_ns - ToNanoseconds(options_.window_s);
  if (!imu.Covers(begin_ns, now_ns) || !IsQuiet(imu, begin_ns, now_ns, options_)) {
    return {};
  }
  const int64_t previous_frame = clones[clones.size() - 2].frame_id;
  const bool has_anchor = last_anchor && FindClone(*state, *last_anchor) >= 0;
  const int64_t anchor_frame = has_anchor ? *last_anchor : previous_frame;
  const auto disparity_px = MedianDisparity(tracks, anchor_frame, clones.back().frame_id);
  const Measurement measurement = StandstillMeasurement(*state, FindClone(*state, anchor_frame));
  if (!disparity_px || *disparity_px > kMaxStandstillDisparityPx ||
      state->SquaredMahalanobis(measurement) >
          ChiSquareQuantile(measurement.num_rows(), kStandstillGateQuantile)) {
    return {};
  }
  state->Update(measurement);
  anchor_frame_id_ = anchor_frame;
  return {true, previous_frame != anchor_frame ? std::optional(previous_frame) : std::nullopt};
}

}  // namespace cairn::fusion
