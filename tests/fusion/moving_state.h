// A filter on the move, for tests of what is done with its clones.
#ifndef CAIRN_TESTS_FUSION_MOVING_STATE_H_
#define CAIRN_TESTS_FUSION_MOVING_STATE_H_

#include <Eigen/Core>
#include <cstdint>

#include "fusion/filter/filter_state.h"
#include "fusion/filter/imu_propagation.h"

namespace cairn::fusion::testing {

inline constexpr int64_t kCloneStepNs = 100'000'000;

// The imu's x axis points ahead, its z axis up; the camera looks ahead.
inline Rig LookingAhead() {
  Eigen::Matrix3d cam_from_imu;
  cam_from_imu << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {Rigid3d(cam_from_imu, Eigen::Vector3d::Zero()), 0.0};
}

// Moves along local's y axis, across the camera's view, at `speed_m_s`. Has `num_clones` clones, of
// the frames 1, 2, ... at 0, kCloneStepNs, ...; not aligned.
inline FilterState MovingState(int num_clones, double speed_m_s, double sigma = 0.01) {
  ImuState imu;
  imu.velocity_in_local = {0.0, speed_m_s, 0.0};
  FilterState state(imu, sigma * sigma * Matrix15d::Identity(), LookingAhead(), {});
  FirstEstimate first = state.first();
  for (int i = 0; i < num_clones; ++i) {
    if (i > 0) {
      ImuState end = state.imu();
      ImuTransition transition;
      for (int k = 0; k < 20; ++k) {
        Propagate({{0.0, 0.0, 0.0}, {0.0, 0.0, 9.81}, 0.005}, ImuNoise(), 9.81, &end, &first,
                  &transition);
      }
      state.Propagate(end, first, transition);
    }
    state.AddClone(i + 1, i * kCloneStepNs, Eigen::Vector3d::Zero());
  }
  return state;
}

// Enters global_from_local, known to 1 m and 1 rad.
inline void AlignAt(const Rigid3d& global_from_local, FilterState* state) {
  state->InitializeGlobal(
      global_from_local, {{{kGlobalIdx, 4}}, Eigen::Matrix4d::Identity(), Eigen::Vector4d::Zero()});
}

}  // namespace cairn::fusion::testing

#endif  // CAIRN_TESTS_FUSION_MOVING_STATE_H_
