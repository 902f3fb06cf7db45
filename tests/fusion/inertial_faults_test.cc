// Faults of the sensors: samples and frames that are missing, and motions that tell nothing.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

#include "fusion/errors.h"
#include "fusion/estimator/estimator.h"
#include "fusion/simulation.h"

namespace cairn::fusion::testing {
namespace {

// Feeds the samples and frames of a device that rests from `begin_ns` on.
void Rest(int64_t begin_ns, double duration_s, Estimator* estimator) {
  const int num_samples = static_cast<int>(200.0 * duration_s);
  int64_t now_ns = begin_ns;
  for (int i = 1; i < num_samples; ++i) {
    now_ns += 5'000'000;
    estimator->AddImu({now_ns, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}});
    if (i % 20 == 0) {
      estimator->AddFrame({now_ns, {}});
    }
  }
}

TEST(Faults, AGapInTheInertialSamplesRestartsLocal) {
  const Simulation simulation = SimulateWalk(4.0);
  Estimator estimator(simulation.MatchingFusionOptions());
  Replay(simulation, 0, &estimator, [](size_t) {});
  const int64_t epoch = estimator.latest().epoch;
  const int64_t later_ns = simulation.imu().back().timestamp_ns + 2'000'000'000;
  EXPECT_EQ(estimator.AddImu({later_ns, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}}),
            ImuStatus::kRestarted);
  EXPECT_EQ(estimator.latest().mode, Mode::kLost);
  Rest(later_ns, 2.0, &estimator);  // It starts again.
  EXPECT_EQ(estimator.latest().mode, Mode::kTracking);
  EXPECT_EQ(estimator.latest().epoch, epoch + 1);
}

// Answers about frames that no longer exist, in a full box.
TEST(Faults, ARestartReportsTheAnswersThatWaitAndUsesNone) {
  const Simulation simulation = SimulateWalk(4.0);
  Estimator estimator(simulation.MatchingFusionOptions());
  std::vector<Answer> held;
  Replay(simulation, 0, &estimator, [&](size_t i) {
    if (const auto query = estimator.PollQuery()) {
      held.push_back(simulation.MakeAnswer(*query, i, {}));
    }
  });
  ASSERT_FALSE(held.empty());
  std::set<int64_t> waiting;
  for (const Answer& answer : held) {
    EXPECT_EQ(estimator.Submit(answer), SubmitStatus::kQueued);
    waiting.insert(answer.query_id);
  }
  Answer stranger;
  stranger.query_id = 1'000'000;
  for (; estimator.Submit(stranger) == SubmitStatus::kQueued; ++stranger.query_id) {
    waiting.insert(stranger.query_id);
  }
  EXPECT_EQ(waiting.size(), 32u);

  const int64_t later_ns = simulation.imu().back().timestamp_ns + 2'000'000'000;
  EXPECT_EQ(estimator.AddImu({later_ns, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}}),
            ImuStatus::kRestarted);
  Rest(later_ns, 4.0, &estimator);
  EXPECT_EQ(estimator.latest().mode, Mode::kTracking);
  EXPECT_EQ(estimator.counters().num_alignments, 0);
  std::multiset<int64_t> reported;
  for (const AnswerReport& report : estimator.TakeReports()) {
    EXPECT_EQ(report.outcome, AnswerOutcome::kUnknownQuery) << report.query_id;
    reported.insert(report.query_id);
  }
  EXPECT_EQ(reported, std::multiset<int64_t>(waiting.begin(), waiting.end()));
}

TEST(Faults, AClockSetBackRestartsLocal) {
  const Simulation simulation = SimulateWalk(4.0);
  Estimator estimator(simulation.MatchingFusionOptions());
  Replay(simulation, 0, &estimator, [](size_t) {});
  ImuStatus status = ImuStatus::kAccepted;
  EXPECT_EQ(estimator.AddImu({5'000'000, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}}),
            ImuStatus::kOutOfOrder);
  EXPECT_NE(estimator.state(), nullptr);  // One stray sample is no reason.
  for (int i = 2; i < 40 && status != ImuStatus::kRestarted; ++i) {
    status = estimator.AddImu({i * 5'000'000, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}});
  }
  EXPECT_EQ(status, ImuStatus::kRestarted);
  EXPECT_EQ(estimator.latest().mode, Mode::kLost);
}

struct PoseQuality {
  double position_error_m = 0.0;  // At the end.
  double nees = 0.0;              // Of the pose, per degree of freedom; mean over the frames.
};

// A simulation of which the frames for which `drops` are left out.
template <typename Drops>
PoseQuality RunWithout(const Simulation& simulation, const Drops& drops) {
  Estimator estimator(simulation.MatchingFusionOptions());
  const Rigid3d local_from_world = simulation.LocalFromWorld(0);
  PoseQuality quality;
  int num_counted = 0;
  size_t next_imu = 0;
  const auto& frames = simulation.frames();
  for (size_t i = 0; i < frames.size(); ++i) {
    while (next_imu < simulation.imu().size() &&
           simulation.imu()[next_imu].timestamp_ns <= frames[i].truth.timestamp_ns) {
      estimator.AddImu(simulation.imu()[next_imu++]);
    }
    if (i == 0) {
      estimator.StartAt(frames[0].truth.timestamp_ns,
                        simulation.DrawStart(0, simulation.options().seed));
    } else if (!drops(i)) {
      estimator.AddFrame({frames[i].truth.timestamp_ns, frames[i].features});
      const auto error = ImuError(estimator.state()->imu(), frames[i].truth, local_from_world);
      quality.position_error_m = error.segment<3>(kPositionIdx).norm();
      if (i > 15) {
        quality.nees +=
            Nees(error.head<6>(), estimator.state()->covariance().topLeftCorner<6, 6>());
        ++num_counted;
      }
    }
  }
  quality.nees /= num_counted;
  return quality;
}

TEST(Faults, DroppedFramesAreSurvivedWithoutOverconfidence) {
  constexpr int kNumRuns = 8;
  double nees_of_thirds = 0.0;
  double nees_of_gap = 0.0;
  for (uint64_t seed = 1; seed <= kNumRuns; ++seed) {
    const Simulation simulation = SimulateWalk(20.0, seed);
    const PoseQuality thirds = RunWithout(simulation, [](size_t i) { return i % 3 != 0; });
    const PoseQuality gap = RunWithout(simulation, [](size_t i) { return i > 80 && i < 120; });
    EXPECT_LT(thirds.position_error_m, 0.6) << seed;
    EXPECT_LT(gap.position_error_m, 0.6) << seed;
    nees_of_thirds += thirds.nees / kNumRuns;
    nees_of_gap += gap.nees / kNumRuns;
  }
  EXPECT_LT(nees_of_thirds, 1.5);
  EXPECT_LT(nees_of_gap, 1.5);
}

// Without motion there is no depth, and the inertial unit alone drifts by 8 to 24 m in this time.
TEST(Faults, PureRotationDoesNotRunAway) {
  constexpr int kNumRuns = 8;
  double nees = 0.0;
  for (uint64_t seed = 1; seed <= kNumRuns; ++seed) {
    SimulationOptions options;
    options.seed = seed;
    options.walk.seed = seed;
    options.walk.speed_m_s = 1e-3;
    options.walk.gait_m = 0.0;
    options.walk.look_around_rad = 1.0;
    options.duration_s = 15.0;
    const PoseQuality quality = RunWithout(Simulation(options), [](size_t) { return false; });
    EXPECT_LT(quality.position_error_m, 1.0) << seed;
    nees += quality.nees / kNumRuns;
  }
  EXPECT_LT(nees, 1.2);
}

TEST(Faults, StandingStillDoesNotDrift) {
  SimulationOptions options;
  options.duration_s = 40.0;
  options.walk.start_stop_s = {-1.0, 8.0};
  const Simulation simulation(options);
  Estimator estimator(simulation.MatchingFusionOptions());
  const Rigid3d local_from_world = simulation.LocalFromWorld(0);
  Eigen::Vector3d error_at_stop;
  Eigen::Vector3d error_at_rest;  // When rest has said what it can about the way before.
  Eigen::Vector3d error_at_end;
  Replay(simulation, 0, &estimator, [&](size_t i) {
    const auto error =
        ImuError(estimator.state()->imu(), simulation.frames()[i].truth, local_from_world);
    (i < 110 ? error_at_stop : i < 150 ? error_at_rest : error_at_end) = error.segment<3>(3);
  });
  EXPECT_GT(estimator.counters().num_standstills, 200);
  EXPECT_LT((error_at_end - error_at_stop).norm(), 0.03);
  EXPECT_LT((error_at_end - error_at_rest).norm(), 0.01);
  EXPECT_LT(error_at_end.norm(), error_at_stop.norm() + 0.01);
  EXPECT_LT(estimator.state()->imu().velocity_in_local.norm(), 0.01);
}

}  // namespace
}  // namespace cairn::fusion::testing
