#include "fusion/estimator/estimator.h"

#include <gtest/gtest.h>

#include <optional>

#include "fusion/errors.h"
#include "fusion/simulation.h"

namespace cairn::fusion::testing {
namespace {

// Replays the simulation and returns the position error in local.
double LocalPositionRms(const Simulation& simulation, bool with_map, Estimator* estimator) {
  const Rigid3d local_from_world = simulation.LocalFromWorld(0);
  Rms position_m;
  Replay(simulation, 0, estimator, [&](size_t i) {
    position_m.Add(
        ImuError(estimator->state()->imu(), simulation.frames()[i].truth, local_from_world)
            .segment<3>(kPositionIdx)
            .norm());
    if (const auto query = with_map ? estimator->PollQuery() : std::nullopt) {
      estimator->Submit(simulation.MakeAnswer(*query, i, {}));
    }
  });
  return position_m.Value();
}

double LocalPositionRms(const Simulation& simulation, bool with_map) {
  Estimator estimator(simulation.MatchingFusionOptions());
  return LocalPositionRms(simulation, with_map, &estimator);
}

TEST(Estimator, TracksAWalkLocally) {
  SimulationOptions options;
  options.duration_s = 20.0;
  const Simulation simulation(options);
  Estimator estimator(simulation.MatchingFusionOptions());
  EXPECT_LT(LocalPositionRms(simulation, /*with_map=*/false, &estimator), 0.15);
  EXPECT_GT(estimator.counters().num_tracks_used, 500);
}

TEST(Estimator, TheMapNeverHurtsLocalTracking) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    SimulationOptions options;
    options.seed = seed;
    options.walk.seed = seed;
    options.map_sigma_m = 0.03;
    const Simulation simulation(options);
    EXPECT_LT(LocalPositionRms(simulation, true), LocalPositionRms(simulation, false)) << seed;
  }
}

}  // namespace
}  // namespace cairn::fusion::testing
