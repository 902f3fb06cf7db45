#include "fusion/estimator/head.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fusion/moving_state.h"

namespace cairn::fusion {
namespace {

constexpr double kGravityMS2 = 9.81;
constexpr int64_t kHeadStepNs = 5'000'000;

// Turning and accelerating.
ImuBuffer Samples(int num_samples) {
  ImuBuffer buffer(1024);
  for (int i = 0; i < num_samples; ++i) {
    const double phase = 0.1 * i;
    buffer.Push({i * kHeadStepNs,
                 {0.3 * std::sin(phase), 0.2, -0.4 * std::cos(phase)},
                 {0.5, std::sin(phase), kGravityMS2}});
  }
  return buffer;
}

FilterState AlignedState() {
  FilterState state = testing::MovingState(3, 1.0);
  testing::AlignAt(Rigid3d(ExpSo3({0.0, 0.0, 0.7}), Eigen::Vector3d(10.0, 20.0, 1.0)), &state);
  return state;
}

TEST(Head, BeginsAtTheState) {
  const FilterState state = AlignedState();
  Head head(ImuNoise(), kGravityMS2);
  head.Restart(state, 40 * kHeadStepNs);
  EXPECT_EQ(head.time_ns(), 40 * kHeadStepNs);
  EXPECT_EQ(head.imu().local_from_imu.translation, state.imu().local_from_imu.translation);
  EXPECT_EQ(head.covariance(), (state.covariance().topLeftCorner<kImuDim, kImuDim>()));
  EXPECT_EQ(head.by_global(), (state.covariance().block<kImuDim, kGlobalDim>(0, kGlobalIdx)));
}

TEST(Head, IsWhereTheFilterWouldPropagateTo) {
  FilterState state = AlignedState();
  const ImuBuffer samples = Samples(60);
  Head head(ImuNoise(), kGravityMS2);
  head.Restart(state, 10 * kHeadStepNs);
  head.CarryOn(samples);
  EXPECT_EQ(head.time_ns(), 59 * kHeadStepNs);

  ImuState end = state.imu();
  FirstEstimate first = {end.local_from_imu.translation, end.velocity_in_local};
  ImuTransition transition;
  samples.ForEachStep(10 * kHeadStepNs, 59 * kHeadStepNs, [&](const ImuStep& step) {
    Propagate(step, ImuNoise(), kGravityMS2, &end, &first, &transition);
  });
  state.Propagate(end, first, transition);
  EXPECT_LT(Difference(head.imu(), state.imu()).norm(), 1e-12);
  EXPECT_LT((head.covariance() - state.covariance().topLeftCorner<kImuDim, kImuDim>()).norm(),
            1e-12);
  EXPECT_LT(
      (head.by_global() - state.covariance().block<kImuDim, kGlobalDim>(0, kGlobalIdx)).norm(),
      1e-12);
}

TEST(Head, SampleBySampleComesToTheSame) {
  const FilterState state = AlignedState();
  Head at_once(ImuNoise(), kGravityMS2);
  Head by_samples(ImuNoise(), kGravityMS2);
  at_once.Restart(state, 0);
  by_samples.Restart(state, 0);
  at_once.CarryOn(Samples(30));
  for (int i = 1; i <= 30; ++i) {
    by_samples.CarryOn(Samples(i));
  }
  EXPECT_EQ(by_samples.time_ns(), at_once.time_ns());
  EXPECT_EQ(by_samples.imu().local_from_imu.translation, at_once.imu().local_from_imu.translation);
  EXPECT_EQ(by_samples.covariance(), at_once.covariance());
}

TEST(Head, StaysWhereNoSampleIsNewer) {
  const FilterState state = AlignedState();
  Head head(ImuNoise(), kGravityMS2);
  head.Restart(state, 29 * kHeadStepNs);
  head.CarryOn(Samples(30));
  EXPECT_EQ(head.time_ns(), 29 * kHeadStepNs);
  EXPECT_EQ(head.covariance(), (state.covariance().topLeftCorner<kImuDim, kImuDim>()));
}

}  // namespace
}  // namespace cairn::fusion
