#include "core/inertial/imu_propagation.h"

#include <cmath>

namespace cairn::fusion {
namespace {

// Integrals of Exp(x w) with W = [w dt]x and t = |w dt|: the mean of Exp over the step (the left
// Jacobian), and the double integral divided by dt^2.
struct RotationIntegrals {
  Eigen::Matrix3d first;   // J_l = I + (1 - cos t)/t^2 W + (t - sin t)/t^3 W^2.
  Eigen::Matrix3d second;  // G_2 = I/2 + (t - sin t)/t^3 W + (t^2/2 - 1 + cos t)/t^4 W^2.
};

RotationIntegrals IntegrateRotation(const Eigen::Vector3d& rotation_vector) {
  const double t = rotation_vector.norm();
  const double tt = t * t;
  double a, b, c;  // Factors of W in J_l; of W^2 in J_l and W in G_2; of W^2 in G_2.
  if (t < 1e-2) {  // A series, because the quotients lose digits.
    a = 0.5 - tt / 24.0;
    b = 1.0 / 6.0 - tt / 120.0;
    c = 1.0 / 24.0 - tt / 720.0;
  } else {
    a = (1.0 - std::cos(t)) / tt;
    b = (t - std::sin(t)) / (tt * t);
    c = (0.5 * tt - 1.0 + std::cos(t)) / (tt * tt);
  }
  const Eigen::Matrix3d w = Skew(rotation_vector);
  const Eigen::Matrix3d ww = w * w;
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  return {identity + a * w + b * ww, 0.5 * identity + b * w + c * ww};
}

Eigen::Vector3d Gravity(double gravity_m_s2) { return {0.0, 0.0, -gravity_m_s2}; }

}  // namespace

Vector15d Difference(const ImuState& a, const ImuState& b) {
  Vector15d error;
  error << LogSo3(a.local_from_imu.rotation * b.local_from_imu.rotation.conjugate()),
      a.local_from_imu.translation - b.local_from_imu.translation,
      a.velocity_in_local - b.velocity_in_local, a.gyro_bias - b.gyro_bias,
      a.accel_bias - b.accel_bias;
  return error;
}

void MoveBy(const Vector15d& error, ImuState* state) {
  Rigid3d& pose = state->local_from_imu;
  pose.rotation = (ExpSo3(error.segment<3>(kThetaIdx)) * pose.rotation).normalized();
  pose.translation += error.segment<3>(kPositionIdx);
  state->velocity_in_local += error.segment<3>(kVelocityIdx);
  state->gyro_bias += error.segment<3>(kGyroBiasIdx);
  state->accel_bias += error.segment<3>(kAccelBiasIdx);
}

ImuState IntegrateImu(const ImuState& start, const ImuStep& step, double gravity_m_s2) {
  const double dt = step.dt_s;
  const Eigen::Vector3d turn = (step.gyro_rad_s - start.gyro_bias) * dt;
  const Eigen::Vector3d force = step.accel_m_s2 - start.accel_bias;
  const RotationIntegrals integrals = IntegrateRotation(turn);
  const Eigen::Quaterniond& rotation = start.local_from_imu.rotation;
  const Eigen::Vector3d gravity = Gravity(gravity_m_s2);
  ImuState end = start;
  end.local_from_imu.rotation = (rotation * ExpSo3(turn)).normalized();
  end.velocity_in_local += gravity * dt + rotation * (integrals.first * force) * dt;
  end.local_from_imu.translation += start.velocity_in_local * dt + 0.5 * gravity * dt * dt +
                                    rotation * (integrals.second * force) * (dt * dt);
  return end;
}

Matrix15d TransitionMatrix(const ImuState& start, const FirstEstimate& first, const ImuState& end,
                           const ImuStep& step, double gravity_m_s2) {
  const double dt = step.dt_s;
  const Eigen::Matrix3d rotation = start.local_from_imu.rotation.toRotationMatrix();
  const Eigen::Vector3d gravity = Gravity(gravity_m_s2);
  const RotationIntegrals integrals = IntegrateRotation((step.gyro_rad_s - start.gyro_bias) * dt);
  const Eigen::Matrix3d force_cross_rotation =
      Skew(rotation * (step.accel_m_s2 - start.accel_bias)) * rotation;
  const Eigen::Vector3d velocity_change =
      end.velocity_in_local - first.velocity_in_local - gravity * dt;
  const Eigen::Vector3d position_change = end.local_from_imu.translation - first.position_in_local -
                                          first.velocity_in_local * dt - 0.5 * gravity * dt * dt;
  Matrix15d phi = Matrix15d::Identity();
  phi.block<3, 3>(kThetaIdx, kGyroBiasIdx) = -rotation * integrals.first * dt;
  phi.block<3, 3>(kVelocityIdx, kThetaIdx) = -Skew(velocity_change);
  phi.block<3, 3>(kVelocityIdx, kGyroBiasIdx) = 0.5 * dt * dt * force_cross_rotation;
  phi.block<3, 3>(kVelocityIdx, kAccelBiasIdx) = -rotation * integrals.first * dt;
  phi.block<3, 3>(kPositionIdx, kThetaIdx) = -Skew(position_change);
  phi.block<3, 3>(kPositionIdx, kVelocityIdx) = dt * Eigen::Matrix3d::Identity();
  phi.block<3, 3>(kPositionIdx, kGyroBiasIdx) = dt * dt * dt / 6.0 * force_cross_rotation;
  phi.block<3, 3>(kPositionIdx, kAccelBiasIdx) = -rotation * integrals.second * dt * dt;
  return phi;
}

Matrix15d ProcessNoise(const ImuNoise& noise, double dt_s) {
  const double sq_gyro = noise.gyro_density * noise.gyro_density;
  const double sq_accel = noise.accel_density * noise.accel_density;
  Matrix15d covariance = Matrix15d::Zero();
  for (int i = 0; i < 3; ++i) {
    covariance(kThetaIdx + i, kThetaIdx + i) = sq_gyro * dt_s;
    covariance(kVelocityIdx + i, kVelocityIdx + i) = sq_accel * dt_s;
    const double cross = 0.5 * sq_accel * dt_s * dt_s;
    covariance(kVelocityIdx + i, kPositionIdx + i) = cross;
    covariance(kPositionIdx + i, kVelocityIdx + i) = cross;
    covariance(kPositionIdx + i, kPositionIdx + i) = sq_accel * dt_s * dt_s * dt_s / 3.0;
    covariance(kGyroBiasIdx + i, kGyroBiasIdx + i) = noise.gyro_walk * noise.gyro_walk * dt_s;
    covariance(kAccelBiasIdx + i, kAccelBiasIdx + i) = noise.accel_walk * noise.accel_walk * dt_s;
  }
  return covariance;
}

void Propagate(const ImuStep& step, const ImuNoise& noise, double gravity_m_s2, ImuState* state,
               FirstEstimate* first, ImuTransition* transition) {
  const ImuState end = IntegrateImu(*state, step, gravity_m_s2);
  const Matrix15d phi = TransitionMatrix(*state, *first, end, step, gravity_m_s2);
  const Matrix15d moved = phi * transition->noise;
  transition->noise.noalias() = moved * phi.transpose();
  transition->noise += ProcessNoise(noise, step.dt_s);
  const Matrix15d chained = phi * transition->phi;
  transition->phi = chained;
  transition->duration_s += step.dt_s;
  *state = end;
  *first = {end.local_from_imu.translation, end.velocity_in_local};
}

}  // namespace cairn::fusion
