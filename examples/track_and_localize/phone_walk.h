// Simulates a walk down a rendered street with a phone in hand: the sensors' measurements and the
// truth.
#ifndef CAIRN_EXAMPLES_TRACK_AND_LOCALIZE_PHONE_WALK_H_
#define CAIRN_EXAMPLES_TRACK_AND_LOCALIZE_PHONE_WALK_H_

#include <cstdint>
#include <vector>

#include "cli/demo/street/street_scene.h"
#include "core/inertial/imu.h"
#include "core/rigid3.h"
#include "fusion/filter/filter_state.h"

namespace cairn {

// Stands for two seconds at one end of the street, then walks along a pavement. The view alternates
// between ahead and across the street. The IMU's x axis points ahead, its z axis up.
class PhoneWalk {
 public:
  explicit PhoneWalk(const StreetOptions& street) : street_(street) {}

  static fusion::Rig PhoneRig();

  // The true pose, smooth in time. enu is at the origin of the street.
  Rigid3d EnuFromImu(double time_s) const;
  Rigid3d CamFromEnu(double time_s) const {
    return PhoneRig().cam_from_imu * EnuFromImu(time_s).Inverse();
  }

  // Returns samples at `rate_hz` from time 0 on, with noise and constant biases.
  std::vector<fusion::ImuSample> Measure(double duration_s, double rate_hz,
                                         const fusion::ImuNoise& noise, uint64_t seed) const;

 private:
  StreetOptions street_;
};

// Converts a time to nanoseconds on the phone's clock.
int64_t PhoneTimeNs(double time_s);

}  // namespace cairn

#endif  // CAIRN_EXAMPLES_TRACK_AND_LOCALIZE_PHONE_WALK_H_
