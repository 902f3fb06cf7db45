// Strapdown integration over one sample, with transition matrix and process noise.
//
// Symbols, as in docs/math/fusion.md: R = local_from_imu, p, v position and velocity in local, b_g
// and b_a the biases, w and a the bias-free rate and specific force, g gravity in local, dt the
// duration. The error is [theta, p, v, b_g, b_a] with R = Exp(theta) R^ (on the left, in local),
// all else additive.
#ifndef CAIRN_FUSION_FILTER_IMU_PROPAGATION_H_
#define CAIRN_FUSION_FILTER_IMU_PROPAGATION_H_

#include <Eigen/Core>

#include "fusion/filter/imu.h"

namespace cairn::fusion {

inline constexpr int kImuDim = 15;
using Vector15d = Eigen::Matrix<double, kImuDim, 1>;
using Matrix15d = Eigen::Matrix<double, kImuDim, kImuDim>;

// Where each part of the error of an ImuState begins.
inline constexpr int kThetaIdx = 0;
inline constexpr int kPositionIdx = 3;
inline constexpr int kVelocityIdx = 6;
inline constexpr int kGyroBiasIdx = 9;
inline constexpr int kAccelBiasIdx = 12;

// The error that moves `b` to `a`.
Vector15d Difference(const ImuState& a, const ImuState& b);

// Moves a state by an error.
void MoveBy(const Vector15d& error, ImuState* state);

// Rate and specific force that hold for `dt_s` seconds, as measured (biases included).
struct ImuStep {
  Eigen::Vector3d gyro_rad_s;
  Eigen::Vector3d accel_m_s2;
  double dt_s = 0.0;
};

// The state `step.dt_s` later, exact for a constant rate and specific force in the body frame.
// `gravity_m_s2` is the magnitude; gravity is (0, 0, -gravity_m_s2) in local.
ImuState IntegrateImu(const ImuState& start, const ImuStep& step, double gravity_m_s2);

// Where the transition matrix is linearised: the first estimates, so that the matrices of
// successive steps multiply to that of the whole and nothing unobservable seems observed (Huang,
// Mourikis and Roumeliotis 2010).
struct FirstEstimate {
  Eigen::Vector3d position_in_local = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_in_local = Eigen::Vector3d::Zero();
};

// Error at the end = phi * error at the start + noise of covariance `noise`.
struct ImuTransition {
  Matrix15d phi = Matrix15d::Identity();
  Matrix15d noise = Matrix15d::Zero();
  double duration_s = 0.0;
};

// Transition matrix of one step from `start` to `end` = IntegrateImu(start, step). `first` holds
// the position and velocity to linearise at in place of start's.
Matrix15d TransitionMatrix(const ImuState& start, const FirstEstimate& first, const ImuState& end,
                           const ImuStep& step, double gravity_m_s2);

// Covariance that one step adds to the error.
Matrix15d ProcessNoise(const ImuNoise& noise, double dt_s);

// Moves `state` and `first` over one step and appends the step to `transition`. Afterwards `first`
// is the new, not yet updated, state. Allocates nothing.
void Propagate(const ImuStep& step, const ImuNoise& noise, double gravity_m_s2, ImuState* state,
               FirstEstimate* first, ImuTransition* transition);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_FILTER_IMU_PROPAGATION_H_
