#include "eval/recordings/measure_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/inertial/imu_propagation.h"

namespace cairn::fusion {
namespace {

constexpr ImuNoise kNoNoise = {0.0, 0.0, 0.0, 0.0};

Eigen::Vector3d Never(int64_t) {
  ADD_FAILURE() << "a density of 0 draws nothing";
  return Eigen::Vector3d::Zero();
}

MotionState AtRest(double) {
  return {Rigid3d(ExpSo3({0.3, -0.2, 1.0}), Eigen::Vector3d(1.0, 2.0, 3.0)),
          Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
}

// A turn on a circle of 2 m, at 0.5 rad/s.
Rigid3d OnCircle(double time_s) {
  const double angle_rad = 0.5 * time_s;
  return Rigid3d(ExpSo3({0.0, 0.0, angle_rad}),
                 Eigen::Vector3d(2.0 * std::cos(angle_rad), 2.0 * std::sin(angle_rad), 0.0));
}

TEST(MotionAlong, ACircleTurnsAndAcceleratesInwards) {
  const MotionState state = MotionAlong(OnCircle)(3.0);
  const Rigid3d pose = OnCircle(3.0);
  EXPECT_LT((state.velocity_in_world - pose.rotation * Eigen::Vector3d(0.0, 1.0, 0.0)).norm(),
            1e-9);
  EXPECT_LT((state.acceleration_in_world - pose.rotation * Eigen::Vector3d(-0.5, 0.0, 0.0)).norm(),
            1e-6);
  EXPECT_LT((state.rate_in_imu - Eigen::Vector3d(0.0, 0.0, 0.5)).norm(), 1e-9);
}

TEST(MeasureMotion, AtRestThereIsGravityAndTheBias) {
  const InertialUnit unit = {
      .noise = kNoNoise, .gyro_bias = {0.01, 0.02, 0.03}, .accel_bias = {0.1, 0.2, 0.3}};
  const InertialWalk walk = MeasureMotion(AtRest, 3, unit, Never);
  ASSERT_EQ(walk.imu.size(), 3u);
  ASSERT_EQ(walk.truth.size(), 3u);
  EXPECT_EQ(walk.imu[2].timestamp_ns, 10'000'000);
  EXPECT_LT((walk.imu[2].gyro_rad_s - unit.gyro_bias).norm(), 1e-12);
  const Eigen::Vector3d force =
      AtRest(0.0).world_from_imu.rotation * (walk.imu[2].accel_m_s2 - unit.accel_bias);
  EXPECT_LT((force - Eigen::Vector3d(0.0, 0.0, 9.81)).norm(), 1e-12);
  EXPECT_EQ(walk.truth[2].accel_bias, unit.accel_bias);
}

TEST(MeasureMotion, IntegratedSamplesGiveThePoses) {
  const InertialUnit unit = {.noise = kNoNoise};
  const InertialWalk walk = MeasureMotion(MotionAlong(OnCircle), 1001, unit, Never);
  ImuState state = walk.truth.front();
  for (size_t i = 0; i + 1 < walk.imu.size(); ++i) {
    const ImuSample &a = walk.imu[i], &b = walk.imu[i + 1];
    const ImuStep step = {0.5 * (a.gyro_rad_s + b.gyro_rad_s), 0.5 * (a.accel_m_s2 + b.accel_m_s2),
                          1e-9 * static_cast<double>(b.timestamp_ns - a.timestamp_ns)};
    state = IntegrateImu(state, step, unit.gravity_m_s2);
  }
  EXPECT_LT(Difference(state, walk.truth.back()).norm(), 1e-4);
}

TEST(MeasureMotion, NoiseAndWalkAreAsAskedFor) {
  const InertialUnit unit = {.noise = {1e-3, 1e-2, 2e-4, 3e-3}};
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  constexpr int kNumSamples = 20'000;
  const InertialWalk walk = MeasureMotion(AtRest, kNumSamples, unit, [&](int64_t) {
    const double x = normal(random), y = normal(random), z = normal(random);
    return Eigen::Vector3d(x, y, z);
  });
  const Eigen::Vector3d force = AtRest(0.0).world_from_imu.rotation.conjugate() *
                                Eigen::Vector3d(0.0, 0.0, unit.gravity_m_s2);
  double sq_gyro = 0.0, sq_accel = 0.0, sq_gyro_step = 0.0, sq_accel_step = 0.0;
  for (size_t i = 0; i + 1 < walk.imu.size(); ++i) {
    const ImuState &now = walk.truth[i], &next = walk.truth[i + 1];
    sq_gyro += (walk.imu[i].gyro_rad_s - now.gyro_bias).squaredNorm();
    sq_accel += (walk.imu[i].accel_m_s2 - force - now.accel_bias).squaredNorm();
    sq_gyro_step += (next.gyro_bias - now.gyro_bias).squaredNorm();
    sq_accel_step += (next.accel_bias - now.accel_bias).squaredNorm();
  }
  const auto sigma = [](double sq_sum) { return std::sqrt(sq_sum / (3.0 * kNumSamples)); };
  const double root_rate = std::sqrt(unit.rate_hz);
  EXPECT_NEAR(sigma(sq_gyro) / (1e-3 * root_rate), 1.0, 0.02);
  EXPECT_NEAR(sigma(sq_accel) / (1e-2 * root_rate), 1.0, 0.02);
  EXPECT_NEAR(sigma(sq_gyro_step) / (2e-4 / root_rate), 1.0, 0.02);
  EXPECT_NEAR(sigma(sq_accel_step) / (3e-3 / root_rate), 1.0, 0.02);
}

TEST(MeasureMotion, ASampleAsksForItsNumbersByItsIndex) {
  std::vector<int64_t> asked;
  MeasureMotion(AtRest, 2, {}, [&](int64_t sample_idx) {
    asked.push_back(sample_idx);
    return Eigen::Vector3d(Eigen::Vector3d::Zero());
  });
  EXPECT_EQ(asked, (std::vector<int64_t>{0, 0, 0, 0, 1, 1, 1, 1}));
}

}  // namespace
}  // namespace cairn::fusion
