#include "fusion/start/starter.h"

#include <algorithm>
#include <vector>

#include "core/inertial/imu_time.h"

namespace cairn::fusion {

Starter::Starter(const StarterOptions& options) : options_(options), tracks_(kMaxTrackedFeatures) {}

void Starter::Clear() {
  tracks_.Clear();
  frames_.clear();
}

std::optional<StartState> Starter::AddFrame(int64_t frame_id, int64_t timestamp_ns,
                                            std::span<const TrackedFeature> features,
                                            const ImuBuffer& imu) {
  const int64_t static_begin_ns = timestamp_ns - ToNanoseconds(kStartWindowS);
  const int64_t begin_ns =
      std::min(static_begin_ns, timestamp_ns - ToNanoseconds(options_.dynamic_start.window_s));
  tracks_.AddFrame(frame_id, options_.camera, features);
  frames_.push_back({frame_id, timestamp_ns});
  while (frames_.front().timestamp_ns < begin_ns) {
    tracks_.DropFrame(frames_.front().frame_id);
    frames_.pop_front();
  }
  const std::optional<StartState> start =
      Moves(static_begin_ns) ? TryDynamic(imu) : TryStatic(static_begin_ns, imu);
  tracks_.DropFinished(frame_id);
  if (start) {
    Clear();
  }
  return start;
}

bool Starter::Moves(int64_t begin_ns) const {
  const auto first =
      std::find_if(frames_.begin(), frames_.end(),
                   [begin_ns](const StartFrame& frame) { return frame.timestamp_ns >= begin_ns; });
  const auto disparity_px = MedianDisparity(tracks_, first->frame_id, frames_.back().frame_id);
  return disparity_px && *disparity_px > kMaxStandstillDisparityPx;
}

std::optional<StartState> Starter::TryStatic(int64_t begin_ns, const ImuBuffer& imu) const {
  const int64_t now_ns = frames_.back().timestamp_ns;
  if (!imu.Covers(begin_ns, now_ns)) {
    return std::nullopt;
  }
  return StaticStart(imu, begin_ns, now_ns, options_.imu_noise, options_.gravity_m_s2,
                     options_.standstill);
}

std::optional<StartState> Starter::TryDynamic(const ImuBuffer& imu) const {
  const DynamicStartOptions& options = options_.dynamic_start;
  const int64_t now_ns = frames_.back().timestamp_ns;
  const double spanned_s = ToSeconds(now_ns - frames_.front().timestamp_ns);
  // Nearly the whole window; and, as it takes the time of many frames, not with each.
  if (!options.enabled || spanned_s < 0.8 * options.window_s || frames_.back().frame_id % 3 != 0 ||
      !imu.Covers(frames_.front().timestamp_ns, now_ns)) {
    return std::nullopt;
  }
  const size_t stride = (frames_.size() - 1) / static_cast<size_t>(kMaxStartFrames) + 1;
  std::vector<StartFrame> frames;
  for (size_t i = (frames_.size() - 1) % stride; i < frames_.size(); i += stride) {
    frames.push_back(frames_[i]);
  }
  return DynamicStart({imu, tracks_, frames, options_.camera, options_.rig, options_.imu_noise,
                       options_.gravity_m_s2, options_.tracks});
}

}  // namespace cairn::fusion
