// Collects samples and frames until the filter can start.
#ifndef CAIRN_FUSION_START_STARTER_H_
#define CAIRN_FUSION_START_STARTER_H_

#include <cstdint>
#include <deque>
#include <optional>
#include <span>

#include "core/camera.h"
#include "core/inertial/imu.h"
#include "core/inertial/imu_buffer.h"
#include "fusion/filter/filter_state.h"
#include "fusion/start/dynamic_start.h"
#include "fusion/start/standstill.h"
#include "fusion/tracks/track_table.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {

struct StarterOptions {
  Camera camera;
  Rig rig;
  ImuNoise imu_noise;
  double gravity_m_s2 = 9.81;
  StandstillOptions standstill;
  DynamicStartOptions dynamic_start;
  TrackUpdateOptions tracks;  // For the dynamic start.
};

// Keeps the frames of a recent window and their tracks. Uses StaticStart if the tracks do not move,
// DynamicStart if they do. Not thread-safe.
class Starter {
 public:
  explicit Starter(const StarterOptions& options);

  // Adds a frame. Ids and timestamps must increase; `timestamp_ns` is in the IMU's clock and must
  // not be after the newest sample of `imu`. If the filter can start at the frame, returns the
  // state there and drops all frames.
  std::optional<StartState> AddFrame(int64_t frame_id, int64_t timestamp_ns,
                                     std::span<const TrackedFeature> features,
                                     const ImuBuffer& imu);

  // Drops all frames.
  void Clear();

 private:
  // Returns whether the tracks have moved over the frames since `begin_ns`.
  bool Moves(int64_t begin_ns) const;
  std::optional<StartState> TryStatic(int64_t begin_ns, const ImuBuffer& imu) const;
  std::optional<StartState> TryDynamic(const ImuBuffer& imu) const;

  StarterOptions options_;
  TrackTable tracks_;
  std::deque<StartFrame> frames_;  // Ordered by time.
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_START_STARTER_H_
