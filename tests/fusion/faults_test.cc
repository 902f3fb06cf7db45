// Tests faults of a device, the network and the map.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <vector>

#include "core/angles.h"
#include "fusion/errors.h"
#include "fusion/estimator/estimator.h"
#include "fusion/simulation.h"

namespace cairn::fusion::testing {
namespace {

// What a transport and a map do: answers `latency` frames later, if `make` gives one.
class Transport {
 public:
  explicit Transport(Estimator* estimator) : estimator_(estimator) {}

  template <typename Latency, typename Make>
  void AfterFrame(size_t frame, const Latency& latency, const Make& make) {
    if (const auto query = estimator_->PollQuery()) {
      if (const auto answer = make(*query, frame)) {
        in_flight_.emplace(frame + latency(*query), *answer);
      }
    }
    for (auto it = in_flight_.begin(); it != in_flight_.end() && it->first <= frame;) {
      estimator_->Submit(it->second);
      it = in_flight_.erase(it);
    }
    for (const AnswerReport& report : estimator_->TakeReports()) {
      reports_.push_back(report);
    }
  }

  const std::vector<AnswerReport>& reports() const { return reports_; }
  int Count(AnswerOutcome outcome) const {
    return static_cast<int>(
        std::count_if(reports_.begin(), reports_.end(),
                      [outcome](const AnswerReport& report) { return report.outcome == outcome; }));
  }

 private:
  Estimator* estimator_;
  std::multimap<size_t, Answer> in_flight_;
  std::vector<AnswerReport> reports_;
};

double GlobalPositionError(const Estimator& estimator, const FrameTruth& truth) {
  const FilterState& state = *estimator.state();
  return (*state.global_from_local() * state.imu().local_from_imu.translation -
          truth.world_from_imu.translation)
      .norm();
}

class Latency : public ::testing::TestWithParam<int> {};

TEST_P(Latency, AnAnswerIsAppliedAtTheFrameItWasAskedOf) {
  const Simulation simulation = SimulateWalk(25.0);
  Estimator estimator(simulation.MatchingFusionOptions());
  Transport transport(&estimator);
  Replay(simulation, 0, &estimator, [&](size_t i) {
    transport.AfterFrame(
        i, [](const Query&) { return static_cast<size_t>(GetParam()); },
        [&](const Query& query, size_t frame) {
          return std::optional(simulation.MakeAnswer(query, frame, {}));
        });
  });
  EXPECT_GT(transport.Count(AnswerOutcome::kApplied), 2);
  EXPECT_EQ(transport.Count(AnswerOutcome::kDisagrees), 0);
  ASSERT_TRUE(estimator.state()->global_from_local().has_value());
  // Five seconds of drift come on top of what the map says.
  EXPECT_LT(GlobalPositionError(estimator, simulation.frames().back().truth), 0.1);
}

INSTANTIATE_TEST_SUITE_P(Frames, Latency, ::testing::Values(1, 2, 10, 50));

TEST(Faults, ADuplicatedAnswerIsUsedOnce) {
  const Simulation simulation = SimulateWalk(8.0);
  Estimator once(simulation.MatchingFusionOptions());
  Estimator twice(simulation.MatchingFusionOptions());
  for (Estimator* estimator : {&once, &twice}) {
    Replay(simulation, 0, estimator, [&](size_t i) {
      if (const auto query = estimator->PollQuery()) {
        const Answer answer = simulation.MakeAnswer(*query, i, {});
        estimator->Submit(answer);
        if (estimator == &twice) {
          estimator->Submit(answer);
        }
      }
    });
  }
  EXPECT_EQ(Eigen::MatrixXd(once.state()->covariance()),
            Eigen::MatrixXd(twice.state()->covariance()));
  const auto reports = twice.TakeReports();
  EXPECT_TRUE(std::any_of(reports.begin(), reports.end(), [](const AnswerReport& report) {
    return report.outcome == AnswerOutcome::kUnknownQuery;
  }));
}

TEST(Faults, TheOrderOfArrivalDoesNotMatter) {
  // Four answers held back and handed in together, in opposite orders.
  const Simulation simulation = SimulateWalk(12.0);
  FusionOptions options = simulation.MatchingFusionOptions();
  options.query.min_interval_s = 0.5;
  Estimator forward(options);
  Estimator backward(options);
  for (Estimator* estimator : {&forward, &backward}) {
    std::vector<Answer> held;
    Replay(simulation, 0, estimator, [&](size_t i) {
      if (const auto query = estimator->PollQuery()) {
        held.push_back(simulation.MakeAnswer(*query, i, {}));
      }
      if (held.size() == 4) {
        if (estimator == &backward) {
          std::reverse(held.begin(), held.end());
        }
        for (Answer& answer : held) {
          estimator->Submit(std::move(answer));
        }
        held.clear();
      }
    });
  }
  ASSERT_TRUE(forward.state()->global_from_local().has_value());
  EXPECT_LT((forward.state()->imu().local_from_imu.translation -
             backward.state()->imu().local_from_imu.translation)
                .norm(),
            1e-9);
  EXPECT_LT((forward.state()->global_from_local()->translation -
             backward.state()->global_from_local()->translation)
                .norm(),
            1e-9);
}

TEST(Faults, AnAnswerAfterTheTimeoutIsDroppedWithAReason) {
  const Simulation simulation = SimulateWalk(10.0);
  FusionOptions options = simulation.MatchingFusionOptions();
  options.query.timeout_s = 1.0;
  Estimator estimator(options);
  Transport transport(&estimator);
  Replay(simulation, 0, &estimator, [&](size_t i) {
    transport.AfterFrame(
        i, [](const Query&) { return size_t{15}; },
        [&](const Query& query, size_t frame) {
          return std::optional(simulation.MakeAnswer(query, frame, {}));
        });
  });
  EXPECT_GT(transport.Count(AnswerOutcome::kCloneGone), 3);
  EXPECT_EQ(transport.Count(AnswerOutcome::kApplied), 0);
  EXPECT_EQ(estimator.latest().mode, Mode::kTracking);
  EXPECT_LE(estimator.state()->clones().size(), 13u);  // Nothing is kept for ever.
}

TEST(Faults, AThirdOfTheMatchesMayBeWrong) {
  const Simulation simulation = SimulateWalk(20.0);
  Estimator estimator(simulation.MatchingFusionOptions());
  Transport transport(&estimator);
  AnswerOptions answers;
  answers.wrong_fraction = 0.3;
  Rms error_m;
  Replay(simulation, 0, &estimator, [&](size_t i) {
    transport.AfterFrame(
        i, [](const Query&) { return size_t{2}; },
        [&](const Query& query, size_t frame) {
          return std::optional(simulation.MakeAnswer(query, frame, answers));
        });
    if (estimator.state()->global_from_local() && i > 60) {
      error_m.Add(GlobalPositionError(estimator, simulation.frames()[i].truth));
    }
  });
  EXPECT_GT(transport.Count(AnswerOutcome::kApplied), 12);
  EXPECT_LT(error_m.Value(), 0.05);
}

TEST(Faults, ConsistentlyWrongAnswersAreRefused) {
  int num_wrong = 0;
  int num_wrong_applied = 0;
  int num_right = 0;
  int num_right_lost = 0;
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const Simulation simulation = SimulateWalk(40.0, seed);
    FusionOptions options = simulation.MatchingFusionOptions();
    options.query.min_interval_s = 0.4;
    Estimator estimator(options);
    Transport transport(&estimator);
    AnswerOptions wrong;
    const Eigen::Vector3d center = simulation.frames()[100].truth.world_from_imu.translation;
    const Eigen::Quaterniond turn = ExpSo3({0.0, 0.0, 20.0 * kRadPerDeg});
    wrong.global_from_true_global =
        Rigid3d(turn, center - turn * center + Eigen::Vector3d(5, 0, 0));
    const auto is_wrong = [](int64_t query_id) { return query_id % 10 == 3; };
    Replay(simulation, 0, &estimator, [&](size_t i) {
      transport.AfterFrame(
          i, [](const Query&) { return size_t{2}; },
          [&](const Query& query, size_t frame) {
            return std::optional(simulation.MakeAnswer(
                query, frame, is_wrong(query.query_id) ? wrong : AnswerOptions()));
          });
    });
    for (const AnswerReport& report : transport.reports()) {
      const bool lost = report.outcome != AnswerOutcome::kApplied &&
                        report.outcome != AnswerOutcome::kAwaitsAlignment;
      if (is_wrong(report.query_id)) {
        ++num_wrong;
        num_wrong_applied += report.outcome == AnswerOutcome::kApplied;
      } else {
        ++num_right;
        num_right_lost += lost;
      }
    }
    EXPECT_LT(GlobalPositionError(estimator, simulation.frames().back().truth), 0.05);
    EXPECT_EQ(estimator.counters().num_realignments, 0);
  }
  EXPECT_GT(num_wrong, 20);
  EXPECT_EQ(num_wrong_applied, 0);
  EXPECT_LE(num_right_lost, num_right / 100);
}

TEST(Faults, AWrongAlignmentIsGivenUpForPersistentContradiction) {
  const Simulation simulation = SimulateWalk(25.0);
  Estimator estimator(simulation.MatchingFusionOptions());
  Transport transport(&estimator);
  AnswerOptions wrong;
  wrong.global_from_true_global = Rigid3d(Eigen::Quaterniond::Identity(), {30.0, 0.0, 0.0});
  Replay(simulation, 0, &estimator, [&](size_t i) {
    transport.AfterFrame(
        i, [](const Query&) { return size_t{2}; },
        [&](const Query& query, size_t frame) {
          return std::optional(
              simulation.MakeAnswer(query, frame, query.query_id <= 5 ? wrong : AnswerOptions()));
        });
  });
  EXPECT_EQ(estimator.counters().num_realignments, 1);
  EXPECT_EQ(estimator.counters().num_alignments, 2);
  EXPECT_LT(GlobalPositionError(estimator, simulation.frames().back().truth), 0.05);
}

TEST(Faults, AMapWithoutAgreementIsNeverBelieved) {
  const Simulation simulation = SimulateWalk(15.0);
  Estimator estimator(simulation.MatchingFusionOptions());
  Transport transport(&estimator);
  Replay(simulation, 0, &estimator, [&](size_t i) {
    transport.AfterFrame(
        i, [](const Query&) { return size_t{2}; },
        [&](const Query& query, size_t frame) {
          AnswerOptions elsewhere;  // Each time somewhere else.
          elsewhere.global_from_true_global =
              Rigid3d(Eigen::Quaterniond::Identity(),
                      {20.0 * static_cast<double>(query.query_id), 0.0, 0.0});
          return std::optional(simulation.MakeAnswer(query, frame, elsewhere));
        });
  });
  EXPECT_EQ(transport.Count(AnswerOutcome::kApplied), 0);
  EXPECT_EQ(estimator.latest().mode, Mode::kAligning);
}

TEST(Faults, ATiltedMapIsRefused) {
  const Simulation simulation = SimulateWalk(10.0);
  Estimator estimator(simulation.MatchingFusionOptions());
  Transport transport(&estimator);
  AnswerOptions tilted;
  tilted.global_from_true_global = Rigid3d(ExpSo3({0.15, 0.0, 0.0}), Eigen::Vector3d::Zero());
  Replay(simulation, 0, &estimator, [&](size_t i) {
    transport.AfterFrame(
        i, [](const Query&) { return size_t{2}; },
        [&](const Query& query, size_t frame) {
          return std::optional(simulation.MakeAnswer(query, frame, tilted));
        });
  });
  EXPECT_GT(transport.Count(AnswerOutcome::kGravityMismatch), 5);
  EXPECT_EQ(transport.Count(AnswerOutcome::kApplied), 0);
}

TEST(Faults, AfterAnOutageThePoseIsRightAtOnceAndLocalDoesNotJump) {
  const Simulation simulation = SimulateWalk(85.0, 4);
  FusionOptions options = simulation.MatchingFusionOptions();
  Estimator estimator(options);
  Transport transport(&estimator);
  const Rigid3d local_from_world = simulation.LocalFromWorld(0);
  double worst_jump_m = 0.0;
  double sq_mahalanobis_at_end_of_outage = 0.0;
  Rigid3d last_shown;
  Rigid3d last_truth;
  Mode mode_in_outage = Mode::kLost;
  Replay(simulation, 0, &estimator, [&](size_t i) {
    const FrameTruth& truth = simulation.frames()[i].truth;
    const Rigid3d shown = estimator.latest().imu.local_from_imu;
    if (i > 700) {  // After the outage: how much what is shown moves beyond the true motion.
      const Eigen::Vector3d moved = shown.translation - last_shown.translation;
      const Eigen::Vector3d true_move =
          local_from_world.rotation * (truth.world_from_imu.translation - last_truth.translation);
      worst_jump_m = std::max(worst_jump_m, std::abs(moved.norm() - true_move.norm()));
    }
    last_shown = shown;
    last_truth = truth.world_from_imu;
    if (i == 700) {
      const auto error = ImuError(estimator.state()->imu(), truth, local_from_world);
      sq_mahalanobis_at_end_of_outage =
          3.0 * Nees(error.segment<3>(3), estimator.state()->covariance().block<3, 3>(3, 3));
      mode_in_outage = estimator.latest().mode;
    }
    transport.AfterFrame(
        i, [](const Query&) { return size_t{2}; },
        [&](const Query& query, size_t frame) -> std::optional<Answer> {
          if (frame > 100 && frame < 700) {
            return std::nullopt;
          }
          return simulation.MakeAnswer(query, frame, {});
        });
  });
  EXPECT_EQ(mode_in_outage, Mode::kCoasting);
  EXPECT_LT(sq_mahalanobis_at_end_of_outage, 14.2);  // Three sigma of three dimensions.
  EXPECT_LT(worst_jump_m, 0.02);
  EXPECT_LT(GlobalPositionError(estimator, simulation.frames().back().truth), 0.05);
  EXPECT_EQ(estimator.counters().num_realignments, 0);
}

TEST(Faults, NumbersThatAreNoneAreRefused) {
  const Simulation simulation = SimulateWalk(5.0);
  Estimator estimator(simulation.MatchingFusionOptions());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(estimator.AddImu({1, {nan, 0.0, 0.0}, {0.0, 0.0, 9.81}}), ImuStatus::kBadInput);
  int64_t bad_query = -1;
  Replay(simulation, 0, &estimator, [&](size_t i) {
    if (const auto query = estimator.PollQuery()) {
      Answer answer = simulation.MakeAnswer(*query, i, {});
      answer.matches[0].x_in_global.x() = nan;
      bad_query = query->query_id;
      estimator.Submit(answer);
    }
    std::vector<TrackedFeature> features = {{999999, {nan, 3.0}}};
    if (i == 20) {
      EXPECT_EQ(estimator.AddFrame({simulation.frames()[i].truth.timestamp_ns + 1000, features}),
                FrameStatus::kAccepted);
    }
  });
  const auto reports = estimator.TakeReports();
  ASSERT_FALSE(reports.empty());
  EXPECT_EQ(reports[0].outcome, AnswerOutcome::kBadInput);
  EXPECT_TRUE(estimator.state()->covariance().allFinite());
}

}  // namespace
}  // namespace cairn::fusion::testing
