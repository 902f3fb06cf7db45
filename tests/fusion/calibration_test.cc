// Tests the whole estimator if the camera's mounting, its clock or the map's level are only roughly
// known.
#include <gtest/gtest.h>

#include <cmath>

#include "fusion/errors.h"
#include "fusion/estimator/estimator.h"
#include "fusion/filter/pose_covariance.h"
#include "fusion/simulation.h"

namespace cairn::fusion {
namespace {

using testing::AnswerOptions;
using testing::Nees;
using testing::Rms;
using testing::Simulation;
using testing::SimulationOptions;

SimulationOptions Walk(uint64_t seed) {
  SimulationOptions options;
  options.seed = seed;
  options.walk.seed = seed;
  options.duration_s = 25.0;
  return options;
}

// Replays a walk whose camera stamps its frames `time_offset_s` early; `after_frame(i)` comes after
// each.
template <typename Callback>
void ReplayWithOffset(const Simulation& simulation, double time_offset_s, Estimator* estimator,
                      const Callback& after_frame) {
  const auto offset_ns = static_cast<int64_t>(std::llround(1e9 * time_offset_s));
  size_t next_imu = 0;
  const auto& imu = simulation.imu();
  for (size_t i = 1; i < simulation.frames().size(); ++i) {
    const auto& frame = simulation.frames()[i];
    while (next_imu < imu.size() &&
           (next_imu == 0 || imu[next_imu - 1].timestamp_ns <= frame.truth.timestamp_ns)) {
      estimator->AddImu(imu[next_imu++]);
    }
    if (i == 1) {
      estimator->StartAt(frame.truth.timestamp_ns, simulation.DrawStart(i, 1));
      continue;
    }
    estimator->AddFrame({frame.truth.timestamp_ns - offset_ns, frame.features});
    after_frame(i);
  }
}

using RigError = Eigen::Matrix<double, kRigDim, 1>;  // Rotation, translation, time offset.

struct RigAtEnd {
  RigError error;
  double nees = 0.0;
};

// Walks with a camera that is mounted 0.027 rad and 0.037 m from where the estimator takes it to be
// at the start, and whose clock is 8 ms off.
RigAtEnd CalibrateOnWalk(uint64_t seed, bool with_map) {
  constexpr double kTimeOffsetS = 0.008;
  const Simulation simulation(Walk(seed));
  FusionOptions options = simulation.MatchingFusionOptions();
  const Rig truth{options.rig.cam_from_imu, kTimeOffsetS};
  options.rig.cam_from_imu =
      Rigid3d(ExpSo3({0.02, -0.015, 0.01}) * truth.cam_from_imu.rotation,
              truth.cam_from_imu.translation + Eigen::Vector3d(0.02, -0.03, 0.01));
  options.state.extrinsic_rotation_sigma_rad = 0.02;
  options.state.extrinsic_translation_sigma_m = 0.03;
  options.state.time_offset_sigma_s = 0.01;
  Estimator estimator(options);
  ReplayWithOffset(simulation, kTimeOffsetS, &estimator, [&](size_t i) {
    if (const auto query = with_map ? estimator.PollQuery() : std::nullopt) {
      estimator.Submit(simulation.MakeAnswer(*query, i, {}));
    }
  });
  const Rig& rig = estimator.state()->rig();
  RigAtEnd end;
  end.error << LogSo3(truth.cam_from_imu.rotation * rig.cam_from_imu.rotation.conjugate()),
      truth.cam_from_imu.translation - rig.cam_from_imu.translation,
      truth.time_offset_s - rig.time_offset_s;
  end.nees =
      Nees(end.error, estimator.state()->covariance().block<kRigDim, kRigDim>(kRigIdx, kRigIdx));
  return end;
}

class Calibration : public ::testing::TestWithParam<bool> {};  // With a map or without.

TEST_P(Calibration, MountingAndTimeOffsetConvergeFromAWrongStart) {
  constexpr int kNumWalks = 8;
  Rms rotation_rad, translation_m, time_s;
  double sum_nees = 0.0;
  for (uint64_t seed = 1; seed <= kNumWalks; ++seed) {
    const RigAtEnd end = CalibrateOnWalk(seed, GetParam());
    rotation_rad.Add(end.error.head<3>().norm());
    translation_m.Add(end.error.segment<3>(3).norm());
    time_s.Add(std::abs(end.error[6]));
    sum_nees += end.nees;
  }
  RecordProperty("rotation_rad", std::to_string(rotation_rad.Value()));
  RecordProperty("translation_m", std::to_string(translation_m.Value()));
  RecordProperty("time_s", std::to_string(time_s.Value()));
  RecordProperty("nees", std::to_string(sum_nees / kNumWalks));
  EXPECT_LT(rotation_rad.Value(), 0.0015);
  EXPECT_LT(translation_m.Value(), GetParam() ? 0.008 : 0.014);  // A walk alone tells less of it.
  EXPECT_LT(time_s.Value(), 0.0002);
  EXPECT_LT(sum_nees / kNumWalks, 1.75);
}
INSTANTIATE_TEST_SUITE_P(Maps, Calibration, ::testing::Bool());

struct TiltedMapErrors {
  double position_m = 0.0, rotation_rad = 0.0;
  double nees = 0.0;  // Of the pose of the camera in global, at the end.
};

TiltedMapErrors RunOnTiltedMap(uint64_t seed, double tilt_sigma_rad) {
  const Simulation simulation(Walk(seed));
  AnswerOptions tilted;
  tilted.global_from_true_global =
      Rigid3d(ExpSo3({0.0, 0.0, 0.5}) * ExpSo3({0.02, -0.015, 0.0}), {40.0, -20.0, 3.0});
  FusionOptions options = simulation.MatchingFusionOptions();
  options.map.tilt_sigma_rad = tilt_sigma_rad;
  Estimator estimator(options);
  Rms position_m, rotation_rad;
  testing::Replay(simulation, 0, &estimator, [&](size_t i) {
    const FilterState& state = *estimator.state();
    if (i > 100 && state.global_from_local()) {
      const Rigid3d estimate = *state.global_from_local() * state.imu().local_from_imu;
      const Rigid3d truth =
          tilted.global_from_true_global * simulation.frames()[i].truth.world_from_imu;
      position_m.Add((estimate.translation - truth.translation).norm());
      rotation_rad.Add(RotationAngleRad(estimate.rotation, truth.rotation));
    }
    if (const auto query = estimator.PollQuery()) {
      estimator.Submit(simulation.MakeAnswer(*query, i, tilted));
    }
  });
  // At the last frame, not at the newest sample, which is some millimeters on.
  const FilterState& state = *estimator.state();
  const PosePrior pose = CameraPrior(state, static_cast<int>(state.clones().size()) - 1);
  const Rigid3d truth = tilted.global_from_true_global *
                        simulation.frames().back().truth.world_from_imu *
                        options.rig.cam_from_imu.Inverse();
  Eigen::Matrix<double, 6, 1> error;
  error << LogSo3(truth.rotation * pose.global_from_cam.rotation.conjugate()),
      truth.translation - pose.global_from_cam.translation;
  return {position_m.Value(), rotation_rad.Value(), Nees(error, pose.covariance)};
}

TEST(SixDofAlignment, TakesUpTheTiltOfAMapThatIsNotLevel) {
  const TiltedMapErrors with_tilt = RunOnTiltedMap(4, 0.03);
  EXPECT_LT(with_tilt.position_m, 0.01);
  EXPECT_LT(with_tilt.rotation_rad, 0.001);
  const TiltedMapErrors level = RunOnTiltedMap(4, 0.0);
  EXPECT_GT(level.rotation_rad, 3.0 * with_tilt.rotation_rad);
}

TEST(SixDofAlignment, IsAsSureAsItIsRight) {
  constexpr int kNumWalks = 8;
  double sum_nees = 0.0;
  for (uint64_t seed = 1; seed <= kNumWalks; ++seed) {
    sum_nees += RunOnTiltedMap(seed, 0.03).nees;
  }
  EXPECT_LT(sum_nees / kNumWalks, 1.44);  // As are 97.5 % of such means, of 8 x 6 squares.
}

}  // namespace
}  // namespace cairn::fusion
