#include "fusion/start/standstill.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <utility>
#include <vector>

#include "core/require.h"
#include "core/rotation_between.h"
#include "core/statistics.h"

namespace cairn::fusion {
namespace {

struct ReadingStatistics {
  Eigen::Vector3d gyro_mean, accel_mean;
  Eigen::Vector3d gyro_std, accel_std;
};

ReadingStatistics Statistics(const ImuBuffer& buffer, int64_t begin_ns, int64_t end_ns) {
  Eigen::Vector3d sum[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  Eigen::Vector3d sq_sum[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  double duration_s = 0.0;
  buffer.ForEachStep(begin_ns, end_ns, [&](const ImuStep& step) {
    sum[0] += step.dt_s * step.gyro_rad_s;
    sum[1] += step.dt_s * step.accel_m_s2;
    sq_sum[0] += step.dt_s * step.gyro_rad_s.cwiseAbs2();
    sq_sum[1] += step.dt_s * step.accel_m_s2.cwiseAbs2();
    duration_s += step.dt_s;
  });
  ReadingStatistics statistics;
  statistics.gyro_mean = sum[0] / duration_s;
  statistics.accel_mean = sum[1] / duration_s;
  const auto deviation = [duration_s](const Eigen::Vector3d& squares, const Eigen::Vector3d& mean) {
    return Eigen::Vector3d((squares / duration_s - mean.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt());
  };
  statistics.gyro_std = deviation(sq_sum[0], statistics.gyro_mean);
  statistics.accel_std = deviation(sq_sum[1], statistics.accel_mean);
  return statistics;
}

bool IsQuiet(const ReadingStatistics& statistics, const StandstillOptions& options) {
  return statistics.gyro_std.maxCoeff() < options.max_gyro_std_rad_s &&
         statistics.accel_std.maxCoeff() < options.max_accel_std_m_s2;
}

// Returns the covariance of a start whose tilt comes from the mean specific force over
// `duration_s`. With R the rotation and u = (0, 0, g): mean = R' u + b_a + n. The derivative of the
// mean by theta is R' [u]x.
Matrix15d StartCovariance(const Eigen::Matrix3d& rotation, double gravity_m_s2, double duration_s,
                          const ImuNoise& noise) {
  // Prior standard deviations. The gyroscope bias is uncertain beyond the noise of the mean
  // reading, for example from a slow turn.
  constexpr double kVelocitySigmaMS = 0.02;
  constexpr double kGyroBiasSigmaRadS = 0.005;
  constexpr double kAccelBiasSigmaMS2 = 0.1;
  Matrix15d covariance = Matrix15d::Zero();
  covariance.diagonal().segment<2>(kThetaIdx).setConstant(1.0);
  covariance.diagonal().segment<3>(kVelocityIdx).setConstant(std::pow(kVelocitySigmaMS, 2));
  covariance.diagonal()
      .segment<3>(kGyroBiasIdx)
      .setConstant(std::pow(noise.gyro_density, 2) / duration_s + std::pow(kGyroBiasSigmaRadS, 2));
  covariance.diagonal().segment<3>(kAccelBiasIdx).setConstant(std::pow(kAccelBiasSigmaMS2, 2));
  Eigen::Matrix<double, 3, kImuDim> jacobian = Eigen::Matrix<double, 3, kImuDim>::Zero();
  jacobian.middleCols<3>(kThetaIdx) =
      rotation.transpose() * Skew(Eigen::Vector3d(0.0, 0.0, gravity_m_s2));
  jacobian.middleCols<3>(kAccelBiasIdx).setIdentity();
  Eigen::Matrix3d innovation = jacobian * covariance * jacobian.transpose();
  innovation.diagonal().array() += std::pow(noise.accel_density, 2) / duration_s;
  const Eigen::Matrix<double, 3, kImuDim> gain =
      innovation.llt().matrixL().solve(jacobian * covariance);
  covariance -= gain.transpose() * gain;
  return covariance;
}

}  // namespace

void StandstillOptions::Validate() const {
  RequireOption(window_s > 0.0, "standstill.window_s must be positive");
  RequireOption(max_gyro_std_rad_s > 0.0, "standstill.max_gyro_std_rad_s must be positive");
  RequireOption(max_accel_std_m_s2 > 0.0, "standstill.max_accel_std_m_s2 must be positive");
}

bool IsQuiet(const ImuBuffer& buffer, int64_t begin_ns, int64_t end_ns,
             const StandstillOptions& options) {
  return IsQuiet(Statistics(buffer, begin_ns, end_ns), options);
}

std::optional<StartState> StaticStart(const ImuBuffer& buffer, int64_t begin_ns, int64_t end_ns,
                                      const ImuNoise& noise, double gravity_m_s2,
                                      const StandstillOptions& options) {
  const ReadingStatistics statistics = Statistics(buffer, begin_ns, end_ns);
  // A bias above 0.1 rad/s or 5 % of gravity means motion or a broken sensor.
  if (!IsQuiet(statistics, options) || !(statistics.gyro_mean.norm() < 0.1) ||
      !(std::abs(statistics.accel_mean.norm() / gravity_m_s2 - 1.0) < 0.05)) {
    return std::nullopt;
  }
  StartState start;
  const Eigen::Quaterniond level = RotationBetween(statistics.accel_mean, Eigen::Vector3d::UnitZ());
  // Yaw is free. Choose the yaw that points the IMU's x axis along local's x axis. If the IMU's x
  // axis is nearly vertical, use its z axis.
  Eigen::Vector3d ahead = level * Eigen::Vector3d::UnitX();
  if (ahead.head<2>().norm() < 0.5) {
    ahead = level * Eigen::Vector3d::UnitZ();
  }
  start.imu.local_from_imu.rotation =
      (Eigen::AngleAxisd(-std::atan2(ahead.y(), ahead.x()), Eigen::Vector3d::UnitZ()) * level)
          .normalized();
  start.imu.gyro_bias = statistics.gyro_mean;
  start.covariance =
      StartCovariance(start.imu.local_from_imu.rotation.toRotationMatrix(), gravity_m_s2,
                      1e-9 * static_cast<double>(end_ns - begin_ns), noise);
  return start;
}

std::optional<double> MedianDisparity(const TrackTable& tracks, int64_t frame_a, int64_t frame_b) {
  constexpr size_t kMinTracks = 10;
  std::vector<double> disparities;
  for (const Track& track : tracks.tracks()) {
    const Observation* a = nullptr;
    const Observation* b = nullptr;
    for (const Observation& observation : track.observations) {
      a = observation.frame_id == frame_a ? &observation : a;
      b = observation.frame_id == frame_b ? &observation : b;
    }
    if (a != nullptr && b != nullptr) {
      disparities.push_back((a->pixel - b->pixel).norm());
    }
  }
  if (disparities.size() < kMinTracks) {
    return std::nullopt;
  }
  return Median(std::move(disparities));
}

Measurement StandstillMeasurement(const FilterState& state, int anchor) {
  // Standard deviations per axis.
  constexpr double kRotationSigmaRad = 0.001;
  constexpr double kPositionSigmaM = 0.002;
  constexpr double kVelocitySigmaMS = 0.01;
  const Rigid3d& now = state.imu().local_from_imu;
  const Rigid3d& then = state.clones()[static_cast<size_t>(anchor)].local_from_imu;
  Measurement measurement;
  measurement.blocks = {{0, 9}, {state.CloneIdx(anchor), kCloneDim}};
  measurement.jacobian = Eigen::MatrixXd::Identity(9, 9 + kCloneDim);
  measurement.jacobian.topRightCorner<kCloneDim, kCloneDim>() =
      -Eigen::Matrix<double, kCloneDim, kCloneDim>::Identity();
  measurement.residual.resize(9);
  measurement.residual << LogSo3(then.rotation * now.rotation.conjugate()),
      then.translation - now.translation, -state.imu().velocity_in_local;
  Eigen::Matrix<double, 9, 1> sigma;
  sigma << Eigen::Vector3d::Constant(kRotationSigmaRad), Eigen::Vector3d::Constant(kPositionSigmaM),
      Eigen::Vector3d::Constant(kVelocitySigmaMS);
  measurement.jacobian = sigma.cwiseInverse().asDiagonal() * measurement.jacobian;
  measurement.residual.array() /= sigma.array();
  return measurement;
}

}  // namespace cairn::fusion
