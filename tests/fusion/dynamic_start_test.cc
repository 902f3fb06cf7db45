#include "fusion/start/dynamic_start.h"

#include <gtest/gtest.h>

#include <optional>

#include "fusion/errors.h"
#include "fusion/estimator/estimator.h"
#include "fusion/simulation.h"

namespace cairn::fusion::testing {
namespace {

// Feeds a walk that never stands still, without a given start. `after_frame` gets the index of each
// frame once it has been processed.
template <typename Callback>
void FeedWithoutStart(const Simulation& simulation, Estimator* estimator,
                      const Callback& after_frame) {
  size_t next_imu = 0;
  const auto& imu = simulation.imu();
  for (size_t i = 0; i < simulation.frames().size(); ++i) {
    const SimulatedFrame& frame = simulation.frames()[i];
    while (next_imu < imu.size() && imu[next_imu].timestamp_ns <= frame.truth.timestamp_ns) {
      estimator->AddImu(imu[next_imu++]);
    }
    estimator->AddFrame({frame.truth.timestamp_ns, frame.features});
    after_frame(i);
  }
}

SimulationOptions WalkOf(uint64_t seed, double duration_s) {
  SimulationOptions options;
  options.seed = seed;
  options.walk.seed = seed;
  options.duration_s = duration_s;
  return options;
}

// The error of a start but for position and yaw, which are right by definition.
Eigen::Matrix<double, 11, 1> StartError(const ImuState& imu, const FrameTruth& truth,
                                        const Rigid3d& local_from_world) {
  const auto error = ImuError(imu, truth, local_from_world);
  Eigen::Matrix<double, 11, 1> start_error;
  start_error << error.head<2>(), error.tail<9>();
  return start_error;
}

TEST(DynamicStart, FindsTheStateOfAWalkerWithinItsOwnUncertainty) {
  double nees = 0.0;
  constexpr int kNumRuns = 12;
  for (uint64_t seed = 1; seed <= kNumRuns; ++seed) {
    const Simulation simulation(WalkOf(seed, 4.0));
    Estimator estimator(simulation.MatchingFusionOptions());
    std::optional<size_t> started;
    FeedWithoutStart(simulation, &estimator, [&](size_t i) {
      if (started || estimator.state() == nullptr) {
        return;
      }
      started = i;
      const FilterState& state = *estimator.state();
      const auto error =
          StartError(state.imu(), simulation.frames()[i].truth, simulation.LocalFromWorld(i));
      Eigen::Matrix<double, 11, 11> covariance;
      covariance << state.covariance().block<2, 2>(0, 0), state.covariance().block<2, 9>(0, 6),
          state.covariance().block<9, 2>(6, 0), state.covariance().block<9, 9>(6, 6);
      EXPECT_LT((error.head<2>().norm()), 0.05) << seed;
      EXPECT_LT((error.segment<3>(2).norm()), 0.3) << seed;
      nees += Nees(error, covariance) / kNumRuns;
    });
    EXPECT_TRUE(started.has_value()) << seed;
  }
  EXPECT_GT(nees, 0.3);
  EXPECT_LT(nees, 2.0);
}

TEST(DynamicStart, TheFilterTracksOnFromIt) {
  const Simulation simulation(WalkOf(2, 20.0));
  Estimator estimator(simulation.MatchingFusionOptions());
  std::optional<Rigid3d> local_from_world;
  double error_m = 0.0;
  FeedWithoutStart(simulation, &estimator, [&](size_t i) {
    if (!local_from_world && estimator.state() != nullptr) {
      local_from_world = simulation.LocalFromWorld(i);
    }
    if (local_from_world) {
      error_m = ImuError(estimator.state()->imu(), simulation.frames()[i].truth, *local_from_world)
                    .segment<3>(kPositionIdx)
                    .norm();
    }
  });
  ASSERT_TRUE(local_from_world.has_value());
  EXPECT_LT(error_m, 0.4);
}

TEST(DynamicStart, RotationAloneIsNoStart) {
  SimulationOptions options = WalkOf(1, 6.0);
  options.walk.speed_m_s = 1e-3;
  options.walk.gait_m = 0.0;
  options.walk.look_around_rad = 1.0;
  const Simulation simulation(options);
  Estimator estimator(simulation.MatchingFusionOptions());
  FeedWithoutStart(simulation, &estimator, [](size_t) {});
  EXPECT_EQ(estimator.state(), nullptr);
}

TEST(DynamicStart, CanBeTurnedOff) {
  const Simulation simulation(WalkOf(1, 4.0));
  FusionOptions options = simulation.MatchingFusionOptions();
  options.dynamic_start.enabled = false;
  Estimator estimator(options);
  FeedWithoutStart(simulation, &estimator, [](size_t) {});
  EXPECT_EQ(estimator.latest().mode, Mode::kInitializing);
}

}  // namespace
}  // namespace cairn::fusion::testing
