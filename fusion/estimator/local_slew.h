// Keeps the published `local` free of jumps.
#ifndef CAIRN_FUSION_ESTIMATOR_LOCAL_SLEW_H_
#define CAIRN_FUSION_ESTIMATOR_LOCAL_SLEW_H_

#include "core/rigid3.h"

namespace cairn::fusion {

// Updates correct the filter's pose in local, by decimeters if the map answers after a long
// silence. A display or a controller must not see such a correction as motion. The published pose
// is therefore shown_from_local * pose. The transform shown_from_local (yaw and translation)
// absorbs each correction and then returns to the identity at a bounded speed. global_from_local is
// published with the inverse, so the pose in global is corrected at once. Not thread-safe.
class LocalSlew {
 public:
  LocalSlew(double max_m_per_frame, double max_rad_per_frame)
      : max_m_per_frame_(max_m_per_frame), max_rad_per_frame_(max_rad_per_frame) {}

  const Rigid3d& shown_from_local() const { return shown_from_local_; }

  // Absorbs a correction of the pose from `before` to `after`, both at the same time.
  void TakeUp(const Rigid3d& before, const Rigid3d& after);

  // Moves shown_from_local toward the identity by one frame. The published pose of `local_from_imu`
  // moves by no more than the bounds.
  void Return(const Rigid3d& local_from_imu);

  void Reset() { shown_from_local_ = Rigid3d(); }

 private:
  double max_m_per_frame_;
  double max_rad_per_frame_;
  Rigid3d shown_from_local_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_ESTIMATOR_LOCAL_SLEW_H_
