// Smooths the corrections of a pose.
#ifndef CAIRN_FUSION_ESTIMATOR_STEADY_POSE_H_
#define CAIRN_FUSION_ESTIMATOR_STEADY_POSE_H_

#include <Eigen/Core>
#include <cstdint>

#include "core/rigid3.h"

namespace cairn::fusion {

struct SteadyPoseOptions {
  // Time after which 37 % of a correction are still held back. 0: nothing is held back.
  double time_constant_s = 0.25;
  // If more than this would be held back, the whole correction is shown at once.
  double max_held_back_m = 0.5;
  double max_held_back_rad = 0.1;

  void Validate() const;
};

// An estimate jumps when a frame or an answer of the map corrects it. A pose drawn over camera
// images must not jump from one image to the next.
//
// A correction has two parts. The first is the device's motion since the last frame, which is now
// better known; this part is shown at once. The second is a change of the last frame's pose, which
// would be a jump. SteadyPose absorbs the second part, so that the last frame's pose does not move,
// and releases it exponentially. The shown pose is the estimate moved by the part that is still
// held back.
//
// LocalSlew is for controllers: its speed is bounded, and it moves a whole frame. SteadyPose moves
// one pose. Not thread-safe.
class SteadyPose {
 public:
  explicit SteadyPose(const SteadyPoseOptions& options) : options_(options) {}

  // Absorbs a correction of this time's pose from `before` to `after` by a measurement that is
  // `since_ns` old. Smooths the correction as if it had arrived when the measurement was taken.
  void TakeUp(int64_t timestamp_ns, const Rigid3d& before, const Rigid3d& after,
              int64_t since_ns = 0);

  // Returns the pose to show for an estimate `pose`. For times before the last correction, holds
  // back as much as at the correction.
  Rigid3d Show(int64_t timestamp_ns, const Rigid3d& pose) const;

  // Releases everything that is held back.
  void Reset();

 private:
  double ShareLeftAfter(int64_t duration_ns) const;

  SteadyPoseOptions options_;
  int64_t taken_up_ns_ = 0;
  // shown = (Exp(turn_) rotation, translation + shift_). The turn does not swing the position about
  // the origin, which may be far away.
  Eigen::Vector3d turn_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_ = Eigen::Vector3d::Zero();
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_ESTIMATOR_STEADY_POSE_H_
