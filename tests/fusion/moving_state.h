// Filter states with clones, for tests.
#ifndef CAIRN_TESTS_FUSION_MOVING_STATE_H_
#define CAIRN_TESTS_FUSION_MOVING_STATE_H_

#include <cstdint>

#include "core/rigid3.h"
#include "fusion/filter/filter_state.h"

namespace cairn::fusion::testing {

inline constexpr int64_t kCloneStepNs = 100'000'000;

// Returns a state with `num_clones` correlated clones on a curve. The clones have the frames 1, 2,
// ... at 0, 1, ... ns. The camera is rotated against the IMU about all axes.
FilterState SomeState(int num_clones, const FilterStateOptions& options = {});

// Returns a state that moves along local's y axis at `speed_m_s` and is not aligned. Its camera
// looks along the IMU's x axis, across the motion. The clones have the frames 1, 2, ... at 0,
// kCloneStepNs,
// ... `sigma` is the standard deviation of each component of the initial state.
FilterState MovingState(int num_clones, double speed_m_s, double sigma = 0.01);

// Enters global_from_local with standard deviations of 1 m and 1 rad.
void AlignAt(const Rigid3d& global_from_local, FilterState* state);

}  // namespace cairn::fusion::testing

#endif  // CAIRN_TESTS_FUSION_MOVING_STATE_H_
