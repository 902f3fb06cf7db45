#include <gtest/gtest.h>

#include "core/inertial/imu_buffer.h"
#include "core/inertial/imu_propagation.h"
#include "support/numeric_jacobian.h"

namespace cairn::fusion {
namespace {

constexpr double kGravity = 9.81;

ImuState SomeState() {
  ImuState state;
  state.local_from_imu = Rigid3d(ExpSo3({0.3, -0.4, 1.2}), Eigen::Vector3d(1.0, -2.0, 3.0));
  state.velocity_in_local = {0.7, -0.2, 0.1};
  state.gyro_bias = {0.01, -0.02, 0.03};
  state.accel_bias = {0.1, 0.2, -0.1};
  return state;
}

ImuStep SomeStep(double dt_s) { return {{0.9, -0.6, 1.4}, {1.0, 3.0, 9.0}, dt_s}; }

ImuState Perturb(const ImuState& state, const Vector15d& error) {
  ImuState moved = state;
  MoveBy(error, &moved);
  return moved;
}

FirstEstimate FirstOf(const ImuState& state) {
  return {state.local_from_imu.translation, state.velocity_in_local};
}

TEST(ImuPropagation, IntegratesAConstantTurnExactly) {
  // A thousand small steps against one large one.
  ImuState fine = SomeState();
  for (int i = 0; i < 1000; ++i) {
    fine = IntegrateImu(fine, SomeStep(0.5 / 1000), kGravity);
  }
  const ImuState coarse = IntegrateImu(SomeState(), SomeStep(0.5), kGravity);
  EXPECT_LT(Difference(fine, coarse).norm(), 1e-10);
}

TEST(ImuPropagation, StaysAtRestUnderGravity) {
  ImuState state;
  for (int i = 0; i < 100; ++i) {
    state = IntegrateImu(state, {Eigen::Vector3d::Zero(), {0.0, 0.0, kGravity}, 0.005}, kGravity);
  }
  EXPECT_LT(Difference(state, ImuState()).norm(), 1e-12);
}

TEST(ImuPropagation, TransitionAgreesWithFiniteDifferences) {
  const ImuState start = SomeState();
  const ImuStep step = SomeStep(0.005);
  const ImuState end = IntegrateImu(start, step, kGravity);
  const Matrix15d phi = TransitionMatrix(start, FirstOf(start), end, step, kGravity);
  const Matrix15d numeric =
      cairn::testing::NumericJacobian<kImuDim, kImuDim>([&](const Vector15d& error) {
        return Difference(IntegrateImu(Perturb(start, error), step, kGravity), end);
      });
  // The gyroscope bias's way into velocity and position is kept to first order in the turn.
  EXPECT_LT((phi - numeric).cwiseAbs().maxCoeff(), 2e-6);
}

TEST(ImuPropagation, TransitionsOfFirstEstimatesChain) {
  // The unobservable directions at the start are carried to those at the end, whatever updates did
  // in between.
  ImuState state = SomeState();
  FirstEstimate first = FirstOf(state);
  const FirstEstimate begin = first;
  ImuTransition transition;
  for (int i = 0; i < 20; ++i) {
    Propagate(SomeStep(0.005), ImuNoise(), kGravity, &state, &first, &transition);
    state.local_from_imu.translation += Eigen::Vector3d(0.01, -0.02, 0.03);  // An update.
    state.velocity_in_local += Eigen::Vector3d(-0.02, 0.01, 0.01);
  }
  const auto yaw_direction = [](const FirstEstimate& at) {
    Vector15d direction = Vector15d::Zero();
    direction.head<3>() = Eigen::Vector3d::UnitZ();
    direction.segment<3>(kPositionIdx) = Eigen::Vector3d::UnitZ().cross(at.position_in_local);
    direction.segment<3>(kVelocityIdx) = Eigen::Vector3d::UnitZ().cross(at.velocity_in_local);
    return direction;
  };
  EXPECT_LT((transition.phi * yaw_direction(begin) - yaw_direction(first)).norm(), 1e-12);
}

TEST(ImuPropagation, NoiseMatchesThatOfSamples) {
  ImuNoise noise;
  ImuState state = SomeState();
  FirstEstimate first = FirstOf(state);
  ImuTransition many;
  for (int i = 0; i < 100; ++i) {
    Propagate({{0, 0, 0}, {0, 0, 0}, 0.001}, noise, kGravity, &state, &first, &many);
  }
  // Over 0.1 s without rotation the closed form holds for the whole interval, too.
  const Matrix15d once = ProcessNoise(noise, 0.1);
  for (const int i : {kVelocityIdx, kPositionIdx, kGyroBiasIdx, kAccelBiasIdx}) {
    EXPECT_NEAR(many.noise(i, i) / once(i, i), 1.0, 0.02) << i;
  }
}

TEST(ImuBuffer, CutsStepsAtBothEnds) {
  ImuBuffer buffer(8);
  for (int i = 0; i < 12; ++i) {  // More than fit.
    buffer.Push({i * 10, Eigen::Vector3d(i, 0, 0), Eigen::Vector3d::Zero()});
  }
  EXPECT_EQ(buffer.oldest_ns(), 40);
  double duration_s = 0.0;
  double integral = 0.0;
  buffer.ForEachStep(43, 87, [&](const ImuStep& step) {
    duration_s += step.dt_s;
    integral += step.dt_s * step.gyro_rad_s.x();
  });
  EXPECT_NEAR(duration_s, 44e-9, 1e-20);
  EXPECT_NEAR(integral / duration_s, 6.5, 1e-12);  // Of a ramp: its value in the middle.
}

TEST(ImuBuffer, KeepsTheSampleBeforeWhereItIsCut) {
  ImuBuffer buffer(8);
  for (int i = 0; i < 5; ++i) {
    buffer.Push({i * 10, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  }
  buffer.DropBefore(25);
  EXPECT_TRUE(buffer.Covers(25, 40));
  EXPECT_FALSE(buffer.Covers(15, 40));
  EXPECT_FALSE(buffer.Covers(25, 41));
}

}  // namespace
}  // namespace cairn::fusion
