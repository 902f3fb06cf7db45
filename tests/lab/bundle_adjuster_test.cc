#include "lab/rivals/fusion/bundle_adjuster.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/inertial/imu_buffer.h"
#include "fusion/simulation.h"
#include "lab/rivals/fusion/comparison.h"

namespace cairn::fusion {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

testing::SimulationOptions ShortWalk() {
  testing::SimulationOptions options;
  options.duration_s = 4.0;
  options.num_features = 80;
  return options;
}

// Feeds a simulation to an adjuster frame by frame.
class Feeder {
 public:
  // `knows_start`: begins in the true state instead of one drawn from what is usually known of it.
  Feeder(const testing::Simulation& simulation, const BundleAdjusterOptions& options,
         bool knows_start = false)
      : simulation_(simulation), buffer_(static_cast<int>(simulation.imu().size())) {
    for (const ImuSample& sample : simulation.imu()) {
      buffer_.Push(sample);
    }
    StartState start = simulation.DrawStart(0, 3);
    if (knows_start) {
      start.imu = TrueStart(simulation);
      start.covariance *= 1e-6;
    }
    const testing::SimulatedFrame& first = simulation.frames()[0];
    adjuster_ = std::make_unique<BundleAdjuster>(
        options, start.imu, start.covariance,
        AdjusterFrame{0, first.truth.timestamp_ns, true, {}, first.features});
  }

  void AddFrame(bool is_keyframe, bool with_features = true) {
    const testing::SimulatedFrame& previous = simulation_.frames()[next_ - 1];
    const testing::SimulatedFrame& frame = simulation_.frames()[next_];
    std::vector<ImuStep> steps;
    buffer_.ForEachStep(previous.truth.timestamp_ns, frame.truth.timestamp_ns,
                        [&](const ImuStep& step) { steps.push_back(step); });
    std::span<const TrackedFeature> features;
    if (with_features) {
      features = frame.features;
    }
    adjuster_->AddFrame(
        {static_cast<int64_t>(next_), frame.truth.timestamp_ns, is_keyframe, steps, features});
    ++next_;
  }

  Rigid3d TrueLocalFromImu() const {
    return simulation_.LocalFromWorld(0) * simulation_.frames()[next_ - 1].truth.world_from_imu;
  }
  double PositionErrorM() const {
    return (adjuster_->state().local_from_imu.translation - TrueLocalFromImu().translation).norm();
  }
  double RotationErrorRad() const {
    return RotationAngleRad(adjuster_->state().local_from_imu.rotation,
                            TrueLocalFromImu().rotation);
  }
  Answer AnswerAt(size_t frame, double wrong_fraction = 0.0) const {
    Query query;
    query.features = simulation_.frames()[frame].features;
    return simulation_.MakeAnswer(
        query, frame,
        {.max_matches = 300, .wrong_fraction = wrong_fraction, .global_from_true_global = {}});
  }
  BundleAdjuster& adjuster() { return *adjuster_; }
  size_t newest() const { return next_ - 1; }

 private:
  static ImuState TrueStart(const testing::Simulation& simulation) {
    const testing::FrameTruth& truth = simulation.frames()[0].truth;
    const Rigid3d local_from_world = simulation.LocalFromWorld(0);
    return {local_from_world * truth.world_from_imu,
            local_from_world.rotation * truth.velocity_in_world, truth.gyro_bias, truth.accel_bias};
  }

  const testing::Simulation& simulation_;
  ImuBuffer buffer_;
  std::unique_ptr<BundleAdjuster> adjuster_;
  size_t next_ = 1;
};

BundleAdjusterOptions OptionsFor(const testing::Simulation& simulation,
                                 const RivalVariant& variant) {
  Recording recording;
  recording.options = simulation.MatchingFusionOptions();
  return RivalOptions(recording, variant);
}

TEST(BundleAdjuster, FollowsTheTruthWithNearlyPerfectSensors) {
  testing::SimulationOptions walk = ShortWalk();
  walk.pixel_sigma_px = 0.01;
  walk.imu_noise = {
      .gyro_density = 1e-6, .accel_density = 1e-5, .gyro_walk = 1e-8, .accel_walk = 1e-7};
  const testing::Simulation simulation(walk);
  for (const DiscardPolicy policy : {DiscardPolicy::kDiscard, DiscardPolicy::kMarginalize}) {
    Feeder feeder(simulation, OptionsFor(simulation, {10, 10, policy}), /*knows_start=*/true);
    for (int i = 0; i < 35; ++i) {
      feeder.AddFrame(true);
      feeder.adjuster().Optimize();
    }
    EXPECT_LT(feeder.PositionErrorM(), 5e-3);
    EXPECT_LT(feeder.RotationErrorRad(), 5e-4);
  }
}

TEST(BundleAdjuster, DoesExactlyTheIterationsAskedFor) {
  const testing::Simulation simulation(ShortWalk());
  for (const int num_iterations : {2, 5, 10}) {
    Feeder feeder(simulation, OptionsFor(simulation, {5, num_iterations, DiscardPolicy::kDiscard}));
    for (int i = 0; i < 12; ++i) {
      feeder.AddFrame(true);
      EXPECT_EQ(feeder.adjuster().Optimize().num_iterations, num_iterations) << "frame " << i;
    }
  }
}

TEST(BundleAdjuster, KeepsTheNewestFrameAndKeyframesBeforeIt) {
  const testing::Simulation simulation(ShortWalk());
  Feeder feeder(simulation, OptionsFor(simulation, {3, 2, DiscardPolicy::kDiscard}));
  for (int i = 1; i <= 12; ++i) {
    feeder.AddFrame(/*is_keyframe=*/i % 4 == 0);
    feeder.adjuster().Optimize();
  }
  EXPECT_THAT(feeder.adjuster().frame_ids(), ElementsAre(4, 8, 12));
  feeder.AddFrame(false);
  feeder.adjuster().Optimize();
  EXPECT_THAT(feeder.adjuster().frame_ids(), ElementsAre(8, 12, 13));
}

TEST(BundleAdjuster, DiscardsTheFurthestCamera) {
  testing::SimulationOptions options = ShortWalk();
  options.duration_s = 6.0;
  options.walk.start_stop_s = {0.5, 1.5};  // Stands, walks for a second, stands.
  const testing::Simulation simulation(options);
  Feeder feeder(simulation, OptionsFor(simulation, {4, 5, DiscardPolicy::kDiscard}));
  for (int i = 1; i <= 40; ++i) {
    feeder.AddFrame(/*is_keyframe=*/i % 5 == 0);
    feeder.adjuster().Optimize();
  }
  EXPECT_THAT(feeder.adjuster().frame_ids(), SizeIs(4));
  EXPECT_EQ(feeder.adjuster().frame_ids().back(), 40);
  EXPECT_GT(feeder.adjuster().frame_ids().front(), 10);  // Those of the first stand are gone.
}

TEST(BundleAdjuster, RunsOnInertialSamplesAlone) {
  const testing::Simulation simulation(ShortWalk());
  for (const DiscardPolicy policy : {DiscardPolicy::kDiscard, DiscardPolicy::kMarginalize}) {
    Feeder feeder(simulation, OptionsFor(simulation, {5, 5, policy}));
    AdjustmentSummary summary;
    for (int i = 0; i < 10; ++i) {
      feeder.AddFrame(true, /*with_features=*/false);
      summary = feeder.adjuster().Optimize();
    }
    EXPECT_EQ(summary.num_global_residuals, 0);
    EXPECT_LT(feeder.PositionErrorM(), 0.3);  // The start's velocity is known to 5 cm/s an axis.
  }
}

TEST(BundleAdjuster, LeavesWrongMatchesOut) {
  const testing::Simulation simulation(ShortWalk());
  Feeder feeder(simulation, OptionsFor(simulation, {10, 5, DiscardPolicy::kDiscard}));
  feeder.adjuster().SetGlobalFromLocal(simulation.LocalFromWorld(0).Inverse());
  for (int i = 1; i <= 20; ++i) {
    feeder.AddFrame(/*is_keyframe=*/i % 5 == 0);
    if (i % 5 == 0) {
      const Answer answer = feeder.AnswerAt(feeder.newest(), /*wrong_fraction=*/0.3);
      const int num_passed = feeder.adjuster().AddMatches(i, answer.matches);
      EXPECT_GT(num_passed, 0.5 * static_cast<double>(answer.matches.size()));
      EXPECT_LT(num_passed, 0.85 * static_cast<double>(answer.matches.size()));
    }
    feeder.adjuster().Optimize();
  }
  const Rigid3d error =
      (*feeder.adjuster().global_from_local() * feeder.adjuster().state().local_from_imu)
          .Inverse() *
      simulation.frames()[20].truth.world_from_imu;
  EXPECT_LT(error.translation.norm(), 0.05);
  EXPECT_LT(LogSo3(error.rotation).norm(), 0.005);
}

TEST(BundleAdjuster, IgnoresAnswersForFramesThatAreGone) {
  const testing::Simulation simulation(ShortWalk());
  Feeder feeder(simulation, OptionsFor(simulation, {3, 2, DiscardPolicy::kDiscard}));
  feeder.adjuster().SetGlobalFromLocal(simulation.LocalFromWorld(0).Inverse());
  for (int i = 1; i <= 10; ++i) {
    feeder.AddFrame(true);
    feeder.adjuster().Optimize();
  }
  EXPECT_EQ(feeder.adjuster().AddMatches(2, feeder.AnswerAt(2).matches), 0);
  EXPECT_GT(feeder.adjuster().AddMatches(10, feeder.AnswerAt(10).matches), 40);
}

TEST(BundleAdjuster, RefusesOptionsWithoutSense) {
  BundleAdjusterOptions options;
  options.num_cameras = 2;
  EXPECT_THROW(options.Validate(), Error);
  options = {};
  options.match_gate_px = 0.0;
  EXPECT_THROW(options.Validate(), Error);
}

// Minimizing over all variables, and over those that remain after marginalization, is the same.
TEST(NormalEquations, MarginalizationKeepsTheMinimum) {
  const Preintegration none(ImuNoise(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  WindowCamera a{ImuState(), none};
  WindowCamera b{ImuState(), none};
  NormalEquations equations({PriorBlock::Pose(&a), PriorBlock::Motion(&a), PriorBlock::Pose(&b)},
                            /*num_eliminated=*/2);
  std::srand(5);
  const Eigen::MatrixXd jacobian = Eigen::MatrixXd::Random(40, 21);
  const Eigen::VectorXd residual = Eigen::VectorXd::Random(40);
  equations.Add({0, 6, 15},
                {jacobian.leftCols(6), jacobian.middleCols(6, 9), jacobian.rightCols(6)}, residual);
  const MarginalPrior prior = equations.Marginalize();
  ASSERT_EQ(prior.size(), 6);
  const Eigen::VectorXd whole = jacobian.colPivHouseholderQr().solve(-residual);
  const Eigen::VectorXd remaining =
      prior.sqrt_information.colPivHouseholderQr().solve(-prior.residual);
  EXPECT_LT((whole.tail(6) - remaining).norm(), 1e-9);
}

}  // namespace
}  // namespace cairn::fusion
