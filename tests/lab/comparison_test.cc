#include "lab/rivals/fusion/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <utility>

#include "core/error.h"
#include "core/inertial/imu_buffer.h"
#include "eval/recordings/room_recordings.h"
#include "eval/recordings/trajectory_interpolation.h"
#include "fusion/errors.h"
#include "fusion/start/standstill.h"
#include "lab/rivals/fusion/run_estimators.h"
#include "lab/trajectories.h"
#include "support/test_data.h"

namespace cairn::fusion {
namespace {

using ::testing::HasSubstr;
using testing::Nees;
using testing::Rms;

Recording ShortRecording() {
  RecordingOptions options = testing::WalkRecordingOptions(1);
  options.max_features = 150;
  return SimulateRecording(testing::WalkTrajectory(12.0, 1), options);
}

TEST(Comparison, AllEstimatorsFindTheMapAndStayNearTheTruth) {
  const Recording recording = ShortRecording();
  const std::vector<MethodResult> results = CompareEstimators(recording, {});
  ASSERT_EQ(results.size(), 2 + PaperVariants().size());
  EXPECT_EQ(results[0].name, "EKF");
  EXPECT_EQ(results[1].name, "EKF, steady");
  for (const MethodResult& result : results) {
    EXPECT_EQ(result.num_counted_frames, recording.frames.size() - recording.first_counted_frame)
        << result.name;
    EXPECT_LT(result.position_rmse_m, 0.1) << result.name;
    EXPECT_LT(result.rotation_rmse_rad, 0.01) << result.name;
    EXPECT_GT(result.mean_matches, 50.0) << result.name;
    EXPECT_GT(result.frame_seconds.mean, 0.0) << result.name;
    EXPECT_LE(result.position_change_m.rms, result.position_change_m.maximum) << result.name;
  }
}

// The point of the paper's figure: what a rival forgets with its cameras comes back as jumps.
TEST(Comparison, TheFilterIsSmootherThanAWindowThatForgets) {
  ComparisonOptions options;
  options.variants = {{10, 10, DiscardPolicy::kDiscard}};
  const std::vector<MethodResult> results = CompareEstimators(ShortRecording(), options);
  EXPECT_LT(results[0].position_change_m.rms, results[2].position_change_m.rms);
  EXPECT_LT(results[0].rotation_change_rad.rms, 0.7 * results[2].rotation_change_rad.rms);
}

TEST(Comparison, MarginalizationMakesTheRivalSmoother) {
  ComparisonOptions options;
  options.variants = {{10, 5, DiscardPolicy::kDiscard}, {10, 5, DiscardPolicy::kMarginalize}};
  const std::vector<MethodResult> results = CompareEstimators(ShortRecording(), options);
  EXPECT_LT(results[3].rotation_change_rad.rms, 0.8 * results[2].rotation_change_rad.rms);
}

// Whoever is steadied, what is shown changes less. It is hardly further off if the corrections are
// small, as the filter's are.
TEST(Comparison, WhatADisplayShowsIsSmoother) {
  ComparisonOptions options;
  options.variants = {{5, 5, DiscardPolicy::kDiscard}};
  options.steadies_rivals = true;
  const std::vector<MethodResult> results = CompareEstimators(ShortRecording(), options);
  ASSERT_EQ(results.size(), 4u);
  for (const auto& [raw, steady] :
       {std::pair(results[0], results[1]), std::pair(results[2], results[3])}) {
    EXPECT_EQ(steady.name, raw.name + ", steady");
    EXPECT_TRUE(steady.is_steady);
    EXPECT_FALSE(raw.is_steady);
    EXPECT_LT(steady.position_change_m.rms, 0.9 * raw.position_change_m.rms) << raw.name;
    EXPECT_EQ(steady.num_counted_frames, raw.num_counted_frames);
  }
  EXPECT_LT(results[1].position_rmse_m, 1.2 * results[0].position_rmse_m);
}

TEST(Comparison, RunsRepeatUpToRounding) {
  const Recording recording = ShortRecording();
  const BundleAdjusterOptions options =
      RivalOptions(recording, {5, 5, DiscardPolicy::kMarginalize});
  const std::vector<FrameRun> a = RunBundleAdjuster(recording, options, false);
  const std::vector<FrameRun> b = RunBundleAdjuster(recording, options, false);
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].global_from_imu.has_value(), b[i].global_from_imu.has_value());
    if (a[i].global_from_imu) {
      EXPECT_LT((a[i].global_from_imu->translation - b[i].global_from_imu->translation).norm(),
                1e-4);
    }
  }
}

TEST(Comparison, TableHasARowAMethodAndTheRatios) {
  MethodResult filter;
  filter.name = "EKF";
  filter.update_seconds.mean = 0.5e-3;
  filter.position_rmse_m = 0.02;
  MethodResult rival;
  rival.name = RivalVariant{5, 2, DiscardPolicy::kMarginalize}.Name();
  rival.update_seconds.mean = 10e-3;
  rival.position_rmse_m = 0.04;
  MethodResult steady = filter;
  steady.name = "EKF, steady";
  steady.position_rmse_m = 0.03;
  const std::string table =
      ComparisonTable("title", std::vector<MethodResult>{filter, steady, rival});
  EXPECT_THAT(table, HasSubstr("title"));
  EXPECT_THAT(table, HasSubstr("BA-5-2-M"));
  EXPECT_THAT(table, HasSubstr("20.0"));
  EXPECT_THAT(table, HasSubstr("0.50"));
  EXPECT_THAT(table, HasSubstr("0.75"));
}

TEST(Comparison, RefusesRecordingsItCannotRun) {
  Recording recording = ShortRecording();
  recording.imu.resize(recording.imu.size() / 2);
  EXPECT_THROW(CompareEstimators(recording, {}), Error);
  recording.frames.resize(recording.first_counted_frame);
  EXPECT_THROW(CompareEstimators(recording, {}), Error);
}

TEST(SimulateRecording, ObservationsAndMatchesAreThoseOfTheTruth) {
  RecordingOptions options = testing::WalkRecordingOptions(3);
  options.map_sigma_m = 0.0;
  const Recording recording = SimulateRecording(testing::WalkTrajectory(6.0, 3), options);
  ASSERT_EQ(recording.frames.size(), 61u);
  double sq_sum = 0.0;
  size_t count = 0;
  for (size_t i = 0; i < recording.frames.size(); ++i) {
    const RecordedFrame& frame = recording.frames[i];
    EXPECT_GT(frame.features.size(), 100u);
    EXPECT_EQ(frame.answer.localized, i > 0 && i % 5 == 0);
    const Rigid3d cam_from_global = options.rig.cam_from_imu * frame.global_from_imu.Inverse();
    for (const MapMatch& match : frame.answer.matches) {
      const auto pixel = options.camera.Project(cam_from_global * match.x_in_global);
      ASSERT_TRUE(pixel);
      sq_sum += (*pixel - match.pixel).squaredNorm();
      ++count;
    }
  }
  EXPECT_NEAR(std::sqrt(sq_sum / (2.0 * static_cast<double>(count))), 1.0, 0.05);
}

TEST(SimulateRecording, TracksGoOnForSeveralFrames) {
  const Recording recording = ShortRecording();
  std::map<uint64_t, int> lengths;
  for (const RecordedFrame& frame : recording.frames) {
    for (const TrackedFeature& feature : frame.features) {
      ++lengths[feature.track_id];
    }
  }
  double sum = 0.0;
  for (const auto& [id, length] : lengths) {
    sum += length;
  }
  EXPECT_GT(sum / static_cast<double>(lengths.size()), 4.0);
}

TEST(SimulateRecording, RefusesWhatItCannotSimulate) {
  RecordingOptions options = testing::WalkRecordingOptions(1);
  Trajectory trajectory = testing::WalkTrajectory(4.0, 1);
  trajectory.poses.resize(5);
  EXPECT_THROW(SimulateRecording(trajectory, options), Error);
  options.track_loss = 2.0;
  EXPECT_THROW(SimulateRecording(testing::WalkTrajectory(4.0, 1), options), Error);
}

TEST(FitToSamples, FindsBiasesAndLevelOfASimulatedWalk) {
  Trajectory trajectory = testing::WalkTrajectory(30.0, 2);
  const Trajectory truth = trajectory;
  const Rigid3d tilt(ExpSo3({0.01, -0.02, 0.0}), Eigen::Vector3d::Zero());
  for (TruePose& pose : trajectory.poses) {
    pose.global_from_imu = tilt * pose.global_from_imu;
  }
  FitToSamples(&trajectory);
  EXPECT_LT((trajectory.gyro_bias - truth.gyro_bias).norm(), 5e-4);
  EXPECT_LT((trajectory.accel_bias - truth.accel_bias).norm(), 0.05);  // It walks.
  const Eigen::Vector3d up_then =
      truth.poses[0].global_from_imu.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d up_now =
      trajectory.poses[0].global_from_imu.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_LT((up_now - up_then).norm(), 0.004);
}

Rms RotationErrors(const Trajectory& trajectory, const Trajectory& truth) {
  Rms errors_rad;
  for (size_t i = 0; i < truth.poses.size(); ++i) {
    errors_rad.Add(RotationAngleRad(trajectory.poses[i].global_from_imu.rotation,
                                    truth.poses[i].global_from_imu.rotation));
  }
  return errors_rad;
}

TEST(SmoothPoses, TakesOutTheNoiseOfMotionCapture) {
  const Trajectory truth = testing::WalkTrajectory(20.0, 4);
  Trajectory trajectory = truth;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (TruePose& pose : trajectory.poses) {
    const Eigen::Vector3d turn(normal(random), normal(random), normal(random));
    const Eigen::Vector3d shift(normal(random), normal(random), normal(random));
    pose.global_from_imu = Rigid3d(ExpSo3(0.003 * turn) * pose.global_from_imu.rotation,
                                   pose.global_from_imu.translation + 0.002 * shift);
  }
  const double before_rad = RotationErrors(trajectory, truth).Value();
  SmoothPoses({0.002, 0.003}, ImuNoise(), &trajectory);
  ASSERT_EQ(trajectory.poses.size(), truth.poses.size());
  EXPECT_LT(RotationErrors(trajectory, truth).Value(), 0.2 * before_rad);
  Rms shifts_m;
  for (size_t i = 0; i < truth.poses.size(); ++i) {
    shifts_m.Add((trajectory.poses[i].global_from_imu.translation -
                  truth.poses[i].global_from_imu.translation)
                     .norm());
  }
  EXPECT_LT(shifts_m.Value(), 0.0015);  // 0.0035 before.
  EXPECT_LT((trajectory.gyro_bias - truth.gyro_bias).norm(), 5e-4);
  EXPECT_LT((trajectory.accel_bias - truth.accel_bias).norm(), 0.03);
}

// 20 poses a second: what happens between them is in the samples.
TEST(SmoothPoses, FillsInWhatMotionCaptureLeavesOut) {
  const Trajectory truth = testing::WalkTrajectory(20.0, 4);
  Trajectory trajectory = truth;
  std::erase_if(trajectory.poses, [&](const TruePose& pose) {
    return (pose.timestamp_ns - truth.poses.front().timestamp_ns) % 50'000'000 != 0;
  });
  const std::vector<TruePose> sparse = trajectory.poses;
  ASSERT_EQ(sparse.size(), 401u);
  SmoothPoses({1e-4, 1e-4}, ImuNoise(), &trajectory);
  Rms filled_rad, straight_rad;
  for (const TruePose& pose : truth.poses) {
    const Eigen::Quaterniond& rotation = pose.global_from_imu.rotation;
    filled_rad.Add(
        RotationAngleRad(PoseAt(trajectory.poses, pose.timestamp_ns).rotation, rotation));
    straight_rad.Add(RotationAngleRad(PoseAt(sparse, pose.timestamp_ns).rotation, rotation));
  }
  EXPECT_LT(filled_rad.Value(), 0.5 * straight_rad.Value());
}

TEST(SmoothPoses, RefusesWhatItCannotSmooth) {
  Trajectory trajectory = testing::WalkTrajectory(2.0, 1);
  EXPECT_THROW(SmoothPoses({0.0, 0.01}, ImuNoise(), &trajectory), Error);
  trajectory.imu.clear();
  EXPECT_THROW(SmoothPoses({}, ImuNoise(), &trajectory), Error);
}

// What inertial samples, integrated over half a second from a true pose, are off by.
struct InertialError {
  Eigen::Vector3d turn;
  Eigen::Vector3d velocity_in_imu;
  Matrix15d noise;  // That `noise` allows.
};

InertialError IntegrationError(const Trajectory& trajectory, const ImuBuffer& buffer,
                               const ImuNoise& noise, int64_t begin_ns, int64_t end_ns) {
  ImuState state{PoseAt(trajectory.poses, begin_ns), VelocityAt(trajectory.poses, begin_ns),
                 trajectory.gyro_bias, trajectory.accel_bias};
  FirstEstimate first = {state.local_from_imu.translation, state.velocity_in_local};
  ImuTransition transition;
  buffer.ForEachStep(begin_ns, end_ns, [&](const ImuStep& step) {
    Propagate(step, noise, trajectory.gravity_m_s2, &state, &first, &transition);
  });
  const Eigen::Quaterniond middle =
      PoseAt(trajectory.poses, begin_ns + (end_ns - begin_ns) / 2).rotation;
  return {
      LogSo3(PoseAt(trajectory.poses, end_ns).rotation * state.local_from_imu.rotation.conjugate()),
      middle.conjugate() * (VelocityAt(trajectory.poses, end_ns) - state.velocity_in_local),
      transition.noise};
}

// Root mean square of the errors, in units of what the noise allows. Of velocity, of the difference
// between successive spans, in which the accelerometer's bias cancels.
struct InertialErrors {
  Rms rotation, velocity;
};

InertialErrors NormalizedInertialErrors(const Trajectory& trajectory, const ImuNoise& noise,
                                        int64_t span_ns) {
  constexpr int64_t kMarginNs = 20'000'000;  // Of velocities.
  ImuBuffer buffer(static_cast<int>(trajectory.imu.size()));
  for (const ImuSample& sample : trajectory.imu) {
    buffer.Push(sample);
  }
  InertialErrors errors;
  std::optional<InertialError> last;
  const int64_t end_ns = trajectory.poses.back().timestamp_ns - kMarginNs;
  for (int64_t t = trajectory.poses.front().timestamp_ns + kMarginNs; t + span_ns < end_ns;
       t += span_ns) {
    const InertialError error = IntegrationError(trajectory, buffer, noise, t, t + span_ns);
    const auto block = [](const InertialError& of, int offset) {
      return Eigen::Matrix3d(of.noise.block<3, 3>(offset, offset));
    };
    errors.rotation.Add(std::sqrt(Nees(error.turn, block(error, kThetaIdx))));
    if (last) {
      const Eigen::Vector3d change = error.velocity_in_imu - last->velocity_in_imu;
      errors.velocity.Add(
          std::sqrt(Nees(change, block(error, kVelocityIdx) + block(*last, kVelocityIdx))));
    }
    last = error;
  }
  return errors;
}

// The noise that estimators are told must be that of the samples against the poses that the
// cameras stand on, or the comparison measures how well each bears being misled.
TEST(RoomRecordings, SamplesAgreeWithThePosesToWithinTheirNoise) {
  CAIRN_SKIP_WITHOUT_DATA("euroc_V1_01_easy");
  CAIRN_SKIP_WITHOUT_DATA("vi_imu_gt");
  for (const auto& [trajectory, options] : AllRooms(cairn::testing::TestDataDir())) {
    const InertialErrors errors =
        NormalizedInertialErrors(trajectory, options.imu_noise, 500'000'000);
    EXPECT_LT(errors.rotation.Value(), 1.5) << trajectory.name;
    EXPECT_GT(errors.velocity.Value(), 0.7) << trajectory.name;
    EXPECT_LT(errors.velocity.Value(), 1.5) << trajectory.name;
    // The filter remembers for seconds.
    const InertialErrors of_seconds =
        NormalizedInertialErrors(trajectory, options.imu_noise, 5'000'000'000);
    EXPECT_GT(of_seconds.rotation.Value(), 0.7) << trajectory.name;
    EXPECT_LT(of_seconds.rotation.Value(), 1.5) << trajectory.name;
  }
}

// The quadcopter stands for its first seconds while its motors start: it shakes by up to 0.1 rad/s
// and 1.3 m/s^2.
TEST(StaticStart, FindsTiltAndRateBiasOfARealDeviceAtRest) {
  CAIRN_SKIP_WITHOUT_DATA("euroc_V1_01_easy");
  const auto [trajectory, recording] = EurocV101(cairn::testing::TestDataDir());
  ImuBuffer buffer(static_cast<int>(trajectory.imu.size()));
  for (const ImuSample& sample : trajectory.imu) {
    buffer.Push(sample);
  }
  const auto start_over = [&](double begin_s, double end_s, const StandstillOptions& options) {
    const int64_t zero_ns = trajectory.poses.front().timestamp_ns;
    return StaticStart(buffer, zero_ns + std::llround(1e9 * begin_s),
                       zero_ns + std::llround(1e9 * end_s), recording.imu_noise,
                       trajectory.gravity_m_s2, options);
  };
  StandstillOptions with_motors;
  with_motors.max_gyro_std_rad_s = 0.1;
  with_motors.max_accel_std_m_s2 = 1.5;
  EXPECT_FALSE(start_over(0.0, 1.5, {}));
  for (const std::optional<StartState>& start :
       {start_over(2.0, 2.5, {}), start_over(0.0, 4.0, with_motors)}) {
    ASSERT_TRUE(start);
    const Eigen::Vector3d up =
        start->imu.local_from_imu.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d true_up =
        trajectory.poses.front().global_from_imu.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    const double tilt_sigma_rad = std::sqrt(start->covariance(kThetaIdx, kThetaIdx));
    EXPECT_LT(up.cross(true_up).norm(), 2.0 * tilt_sigma_rad);
    EXPECT_LT((start->imu.gyro_bias - trajectory.gyro_bias).norm(), 2.5e-3);  // Of 0.08.
  }
  // It flies.
  EXPECT_FALSE(start_over(24.0, 25.0, {}));
  EXPECT_FALSE(start_over(24.0, 25.0, with_motors));
}

// On real samples, the estimators must still find the map and hold on to it.
TEST(Comparison, HoldsOnRealInertialSamples) {
  CAIRN_SKIP_WITHOUT_DATA("vi_imu_gt");
  Room room = EurocV102(cairn::testing::TestDataDir());
  room.options.duration_s = 15.0;
  ComparisonOptions comparison;
  comparison.variants = {{5, 5, DiscardPolicy::kDiscard}, {5, 5, DiscardPolicy::kMarginalize}};
  for (const MethodResult& result :
       CompareEstimators(SimulateRecording(room.trajectory, room.options), comparison)) {
    EXPECT_LT(result.position_rmse_m, 0.1) << result.name;
    EXPECT_LT(result.rotation_rmse_rad, 0.015) << result.name;
  }
}

}  // namespace
}  // namespace cairn::fusion
