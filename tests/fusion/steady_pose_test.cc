#include "fusion/estimator/steady_pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/error.h"
#include "fusion/estimator/estimator.h"
#include "fusion/simulation.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion::testing {
namespace {

constexpr int64_t kFrameNs = 33'000'000;
const Rigid3d kBefore(ExpSo3({0.3, -0.2, 1.0}), {1000.0, -2000.0, 30.0});
const Rigid3d kAfter(ExpSo3({0.0, 0.01, 0.02}) * kBefore.rotation,
                     kBefore.translation + Eigen::Vector3d(0.06, 0.08, 0.0));  // 10 cm.

double DistanceM(const Rigid3d& a, const Rigid3d& b) {
  return (a.translation - b.translation).norm();
}

double TurnRad(const Rigid3d& a, const Rigid3d& b) {
  return LogSo3(a.rotation * b.rotation.conjugate()).norm();
}

TEST(SteadyPose, PassesACorrectionOnWithTheTimeConstant) {
  const SteadyPoseOptions options;
  SteadyPose steady(options);
  steady.TakeUp(0, kBefore, kAfter);
  Rigid3d last = steady.Show(0, kAfter);
  EXPECT_LT(DistanceM(last, kBefore), 1e-12);
  EXPECT_LT(TurnRad(last, kBefore), 1e-12);
  const double share = 1e-9 * kFrameNs / options.time_constant_s;
  for (int64_t t = kFrameNs; t < 2'000'000'000; t += kFrameNs) {
    const Rigid3d shown = steady.Show(t, kAfter);
    EXPECT_LE(DistanceM(shown, last), share * DistanceM(kBefore, kAfter));
    EXPECT_LE(TurnRad(shown, last), share * TurnRad(kBefore, kAfter));
    EXPECT_LT(DistanceM(shown, kAfter), DistanceM(last, kAfter));
    last = shown;
  }
  EXPECT_NEAR(DistanceM(steady.Show(250'000'000, kAfter), kAfter), 0.1 * std::exp(-1.0), 1e-9);
  EXPECT_LT(DistanceM(steady.Show(2'000'000'000, kAfter), kAfter), 1e-3);
  EXPECT_LT(TurnRad(steady.Show(2'000'000'000, kAfter), kAfter), 1e-4);
}

TEST(SteadyPose, CorrectionsAddUpWithoutAJump) {
  SteadyPose steady((SteadyPoseOptions()));
  Rigid3d pose = kBefore;
  for (int64_t t = 0; t < 20 * kFrameNs; t += kFrameNs) {
    const Rigid3d corrected(ExpSo3({0.001, 0.0, 0.002}) * pose.rotation,
                            pose.translation + Eigen::Vector3d(0.01, 0.0, -0.02));
    const Rigid3d shown = steady.Show(t, pose);
    steady.TakeUp(t, pose, corrected);
    EXPECT_LT(DistanceM(steady.Show(t, corrected), shown), 1e-9);
    EXPECT_LT(TurnRad(steady.Show(t, corrected), shown), 1e-12);
    pose = corrected;
  }
}

TEST(SteadyPose, PassesOnWhatHasBeenKnownForAWhile) {
  SteadyPose late((SteadyPoseOptions()));
  SteadyPose early((SteadyPoseOptions()));
  late.TakeUp(5 * kFrameNs, kBefore, kAfter, 2 * kFrameNs);
  early.TakeUp(3 * kFrameNs, kBefore, kAfter);
  for (int64_t t = 5 * kFrameNs; t < 20 * kFrameNs; t += kFrameNs) {
    EXPECT_LT(DistanceM(late.Show(t, kAfter), early.Show(t, kAfter)), 1e-9);
    EXPECT_LT(TurnRad(late.Show(t, kAfter), early.Show(t, kAfter)), 1e-9);
  }
}

TEST(SteadyPose, WithoutATimeConstantShowsThePoseItself) {
  SteadyPoseOptions options;
  options.time_constant_s = 0.0;
  SteadyPose steady(options);
  steady.TakeUp(0, kBefore, kAfter);
  EXPECT_EQ(steady.Show(0, kAfter).translation, kAfter.translation);
  EXPECT_EQ(steady.Show(0, kAfter).rotation.coeffs(), kAfter.rotation.coeffs());
}

TEST(SteadyPose, PassesOnAtOnceWhatExceedsTheBounds) {
  SteadyPoseOptions options;
  options.max_held_back_m = 0.15;
  SteadyPose steady(options);
  steady.TakeUp(0, kBefore, kAfter);
  EXPECT_LT(DistanceM(steady.Show(0, kAfter), kBefore), 1e-12);
  const Rigid3d further(kAfter.rotation, kAfter.translation + Eigen::Vector3d(0.06, 0.08, 0.0));
  steady.TakeUp(0, kAfter, further);
  EXPECT_EQ(DistanceM(steady.Show(0, further), further), 0.0);
  const Rigid3d turned(ExpSo3({0.2, 0.0, 0.0}) * further.rotation, further.translation);
  steady.TakeUp(0, further, turned);
  EXPECT_LT(TurnRad(steady.Show(0, turned), turned), 1e-12);
}

TEST(SteadyPose, BearsAClockThatJumps) {
  SteadyPose steady((SteadyPoseOptions()));
  steady.TakeUp(1'000'000'000'000, kBefore, kAfter);
  EXPECT_LT(DistanceM(steady.Show(0, kAfter), kBefore), 1e-12);
  EXPECT_EQ(DistanceM(steady.Show(std::numeric_limits<int64_t>::max() / 2, kAfter), kAfter), 0.0);
}

TEST(SteadyPose, RefusesNonsense) {
  SteadyPoseOptions options;
  EXPECT_NO_THROW(options.Validate());
  options.time_constant_s = -0.1;
  EXPECT_THROW(options.Validate(), Error);
  options.time_constant_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(options.Validate(), Error);
  options = {};
  options.max_held_back_rad = 4.0;
  EXPECT_THROW(options.Validate(), Error);
}

Simulation SteadyWalk(double duration_s) {
  SimulationOptions options;
  options.duration_s = duration_s;
  options.map_sigma_m = 0.03;
  return Simulation(options);
}

// How an estimator's poses in global move as it takes up a frame, no time passing.
struct Moves {
  double most_m = 0.0;
  double most_steady_m = 0.0;
  double most_of_last_frame_m = 0.0;  // The pose shown of the frame before.
  double most_held_back_m = 0.0;
  double most_held_back_at_alignment_m = 0.0;
};

// What is held back of the position at the newest sample, in global.
Eigen::Vector3d HeldBack(const Estimate& estimate) {
  return estimate.steady_global_from_imu.translation - estimate.global_from_imu.translation;
}

// Where the imu was in a frame, in global; nothing if it is not in the window.
std::optional<Eigen::Vector3d> PositionAt(const Estimator& estimator, int64_t frame_id) {
  const FilterState* state = estimator.state();
  const int clone = state == nullptr ? -1 : FindClone(*state, frame_id);
  if (clone < 0 || !state->global_from_local()) {
    return std::nullopt;
  }
  return (*state->global_from_local() * state->clones()[static_cast<size_t>(clone)].local_from_imu)
      .translation;
}

// The frame in which the newest clone was taken; 0 if there is none.
int64_t LastFrame(const Estimator& estimator) {
  const FilterState* state = estimator.state();
  return state == nullptr || state->clones().empty() ? 0 : state->clones().back().frame_id;
}

// Answers come with the next frame; the map stands elsewhere until `num_wrong_queries`.
Moves MovesOf(const Simulation& simulation, int64_t num_wrong_queries,
              const SteadyPoseOptions& options, Estimator* estimator) {
  AnswerOptions wrong;
  wrong.global_from_true_global = Rigid3d(Eigen::Quaterniond::Identity(), {30.0, 0.0, 0.0});
  const double share_kept = std::exp(-0.1 / options.time_constant_s);  // From frame to frame.
  Moves moves;
  Eigen::Vector3d held_back = Eigen::Vector3d::Zero();  // After the frame before.
  size_t next_imu = 0;
  for (size_t i = 0; i < simulation.frames().size(); ++i) {
    const SimulatedFrame& frame = simulation.frames()[i];
    while (next_imu < simulation.imu().size() &&
           (next_imu == 0 ||
            simulation.imu()[next_imu - 1].timestamp_ns <= frame.truth.timestamp_ns)) {
      estimator->AddImu(simulation.imu()[next_imu++]);
    }
    if (i == 0) {
      estimator->StartAt(frame.truth.timestamp_ns, simulation.DrawStart(0, 1));
      continue;
    }
    const Estimate before = estimator->latest();
    const int64_t num_alignments = estimator->counters().num_alignments;
    const int64_t last_frame = LastFrame(*estimator);
    const auto last_before = PositionAt(*estimator, last_frame);
    estimator->AddFrame({frame.truth.timestamp_ns, frame.features});
    const Estimate& after = estimator->latest();
    const auto last_after = PositionAt(*estimator, last_frame);
    const double held_back_m = HeldBack(after).norm();
    moves.most_held_back_m = std::max(moves.most_held_back_m, held_back_m);
    if (estimator->counters().num_alignments != num_alignments) {
      moves.most_held_back_at_alignment_m =
          std::max(moves.most_held_back_at_alignment_m, held_back_m);
    } else if (last_before && last_after) {
      EXPECT_EQ(before.timestamp_ns, after.timestamp_ns);
      moves.most_m =
          std::max(moves.most_m, DistanceM(before.global_from_imu, after.global_from_imu));
      moves.most_steady_m = std::max(moves.most_steady_m, DistanceM(before.steady_global_from_imu,
                                                                    after.steady_global_from_imu));
      moves.most_of_last_frame_m = std::max(
          moves.most_of_last_frame_m,
          (*last_after + HeldBack(after) / share_kept - (*last_before + held_back)).norm());
    }
    held_back = HeldBack(after);
    if (const auto query = estimator->PollQuery()) {
      estimator->Submit(simulation.MakeAnswer(
          *query, i, query->query_id <= num_wrong_queries ? wrong : AnswerOptions()));
    }
  }
  return moves;
}

TEST(SteadyPose, OfAnEstimatorDoesNotMoveTheLastFrameWhenTheNextCorrectsIt) {
  const Simulation simulation = SteadyWalk(15.0);
  Estimator estimator(simulation.MatchingFusionOptions());
  const Moves moves = MovesOf(simulation, 0, {}, &estimator);
  EXPECT_EQ(estimator.counters().num_alignments, 1);
  EXPECT_GT(moves.most_m, 5e-3);
  EXPECT_GT(moves.most_held_back_m, 5e-3);
  EXPECT_LT(moves.most_of_last_frame_m, 1e-9);
  // The share of a frame, and what the frame says about the way since the last.
  EXPECT_LT(moves.most_steady_m, 0.5 * moves.most_m);
  EXPECT_EQ(moves.most_held_back_at_alignment_m, 0.0);
}

TEST(SteadyPose, OfAnEstimatorTakesANewAlignmentAtOnce) {
  const Simulation simulation = SteadyWalk(20.0);
  FusionOptions options = simulation.MatchingFusionOptions();
  options.steady.max_held_back_m = 100.0;
  Estimator estimator(options);
  const Moves moves = MovesOf(simulation, 5, options.steady, &estimator);
  EXPECT_EQ(estimator.counters().num_alignments, 2);
  EXPECT_EQ(moves.most_held_back_at_alignment_m, 0.0);
  EXPECT_LT(moves.most_held_back_m, 1.0);
  EXPECT_LT(moves.most_of_last_frame_m, 1e-9);
}

TEST(SteadyPose, OfAnEstimatorWithoutATimeConstantIsTheEstimate) {
  const Simulation simulation = SteadyWalk(10.0);
  FusionOptions options = simulation.MatchingFusionOptions();
  options.steady.time_constant_s = 0.0;
  Estimator estimator(options);
  const Moves moves = MovesOf(simulation, 0, {}, &estimator);
  EXPECT_GT(moves.most_m, 1e-3);
  EXPECT_EQ(moves.most_held_back_m, 0.0);
}

TEST(SteadyPose, OfAnEstimatorSurvivesAClockSetBack) {
  const Simulation simulation = SteadyWalk(8.0);
  Estimator estimator(simulation.MatchingFusionOptions());
  MovesOf(simulation, 0, {}, &estimator);
  ASSERT_TRUE(estimator.latest().has_global);
  ImuStatus status = ImuStatus::kAccepted;
  for (int i = 1; i < 40 && status != ImuStatus::kRestarted; ++i) {
    status = estimator.AddImu({i * 5'000'000, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}});
  }
  ASSERT_EQ(status, ImuStatus::kRestarted);
  // The same walk once more, in the new epoch.
  const Moves moves = MovesOf(simulation, 0, {}, &estimator);
  EXPECT_TRUE(estimator.latest().has_global);
  EXPECT_EQ(estimator.counters().num_alignments, 2);
  EXPECT_EQ(moves.most_held_back_at_alignment_m, 0.0);
  EXPECT_LT(moves.most_of_last_frame_m, 1e-9);
  EXPECT_TRUE(estimator.latest().steady_global_from_imu.translation.allFinite());
  EXPECT_TRUE(estimator.latest().steady_global_from_imu.rotation.coeffs().allFinite());
}

}  // namespace
}  // namespace cairn::fusion::testing
