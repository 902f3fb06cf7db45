// Keeps the published `local` free of jumps.
#ifndef CAIRN_FUSION_CLIENT_LOCAL_SLEW_H_
#define CAIRN_FUSION_CLIENT_LOCAL_SLEW_H_

#include "core/rigid3.h"

namespace cairn::fusion {

// Updates correct the filter's pose in local, by decimetres when the map answers after a long
// silence. A display or a controller must not see that as motion. So what is shown is
// shown_from_local * pose, where shown_from_local (yaw and translation) takes up each correction
// and then returns to the identity at a bounded speed. As global_from_local is shown with the
// inverse, the pose in global is corrected at once. Not thread-safe.
class LocalSlew {
 public:
  LocalSlew(double max_m_per_frame, double max_rad_per_frame)
      : max_m_per_frame_(max_m_per_frame), max_rad_per_frame_(max_rad_per_frame) {}

  const Rigid3d& shown_from_local() const { return shown_from_local_; }

  // The pose was `before` and has been corrected to `after`, at one instant.
  void TakeUp(const Rigid3d& before, const Rigid3d& after);

  // One frame's return towards the identity, which moves what is shown of the pose
  // `local_from_imu` by no more than the bounds.
  void Return(const Rigid3d& local_from_imu);

  void Reset() { shown_from_local_ = Rigid3d(); }

 private:
  double max_m_per_frame_;
  double max_rad_per_frame_;
  Rigid3d shown_from_local_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_CLIENT_LOCAL_SLEW_H_
