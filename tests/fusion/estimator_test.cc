#include "fusion/estimator.h"

#include <gtest/gtest.h>

#include "fusion/errors.h"
#include "fusion/simulation.h"

namespace cairn::fusion::testing {
namespace {

TEST(Estimator, TracksAWalkLocally) {
  SimulationOptions options;
  options.duration_s = 20.0;
  const Simulation simulation(options);
  Estimator estimator(simulation.MatchingOptions());
  const Rigid3d local_from_world = simulation.LocalFromWorld(0);
  Rms position_m;
  Replay(simulation, 0, &estimator, [&](size_t i) {
    position_m.Add(
        ImuError(estimator.state()->imu(), simulation.frames()[i].truth, local_from_world)
            .segment<3>(kPositionIdx)
            .norm());
  });
  EXPECT_LT(position_m.Value(), 0.3);
  EXPECT_GT(estimator.counters().num_tracks_used, 500);
}

}  // namespace
}  // namespace cairn::fusion::testing
