// Passes corrections of a pose on gently.
#ifndef CAIRN_FUSION_CLIENT_STEADY_POSE_H_
#define CAIRN_FUSION_CLIENT_STEADY_POSE_H_

#include <Eigen/Core>
#include <cstdint>

#include "core/rigid3.h"

namespace cairn::fusion {

struct SteadyPoseOptions {
  // This long after a correction 37 % of it are still held back. 0: nothing is.
  double time_constant_s = 0.25;
  // If more than this would be held back, all is passed on at once.
  double max_held_back_m = 0.5;
  double max_held_back_rad = 0.1;

  void Validate() const;
};

// An estimate jumps where a frame or an answer of the map corrects it. What is drawn over camera
// images must not jump from one to the next. A correction says two things: how the device has moved
// since the last frame, which is better known than before and is shown at once, and where it was at
// the last frame, which is a jump. So what is shown is the pose moved by what is held back of the
// jumps: it takes up each of them, so that the last frame's pose does not move, and decays
// exponentially from there. LocalSlew, with its bounded speed, is for controllers and moves a whole
// frame; this moves one pose. Not thread-safe.
class SteadyPose {
 public:
  explicit SteadyPose(const SteadyPoseOptions& options) : options_(options) {}

  // The pose of this instant was corrected from `before` to `after` by a measurement that is
  // `since_ns` old. Smooths the correction as if it had arrived when the measurement was taken.
  void TakeUp(int64_t timestamp_ns, const Rigid3d& before, const Rigid3d& after,
              int64_t since_ns = 0);

  // What is shown of a pose at an instant; before the last correction, as at it.
  Rigid3d Show(int64_t timestamp_ns, const Rigid3d& pose) const;

  // Passes on all that is held back.
  void Reset();

 private:
  double ShareLeftAfter(int64_t duration_ns) const;

  SteadyPoseOptions options_;
  int64_t taken_up_ns_ = 0;
  // shown = (Exp(turn_) rotation, translation + shift_): the turn does not swing the position about
  // the origin, which may be far away.
  Eigen::Vector3d turn_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_ = Eigen::Vector3d::Zero();
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_CLIENT_STEADY_POSE_H_
