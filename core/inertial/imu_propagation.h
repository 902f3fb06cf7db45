// Strapdown integration over one step, with transition matrix and process noise.
//
// Symbols, as in docs/math/fusion.md: R = local_from_imu; p and v are position and velocity in
// local; b_g and b_a are the biases; w and a are the bias-free rate and specific force; g is
// gravity in local; dt is the duration. The error is [theta, p, v, b_g, b_a]. The rotation error is
// on the left, in local: R = Exp(theta) R^. All other errors are additive.
#ifndef CAIRN_CORE_INERTIAL_IMU_PROPAGATION_H_
#define CAIRN_CORE_INERTIAL_IMU_PROPAGATION_H_

#include <Eigen/Core>

#include "core/inertial/imu.h"

namespace cairn::fusion {

inline constexpr int kImuDim = 15;
using Vector15d = Eigen::Matrix<double, kImuDim, 1>;
using Matrix15d = Eigen::Matrix<double, kImuDim, kImuDim>;

// Offsets of the parts of an ImuState's error.
inline constexpr int kThetaIdx = 0;
inline constexpr int kPositionIdx = 3;
inline constexpr int kVelocityIdx = 6;
inline constexpr int kGyroBiasIdx = 9;
inline constexpr int kAccelBiasIdx = 12;

// Returns the error that moves `b` to `a`.
Vector15d Difference(const ImuState& a, const ImuState& b);

// Moves `state` by `error`.
void MoveBy(const Vector15d& error, ImuState* state);

// Measured rate and specific force (biases included), held constant for `dt_s` seconds.
struct ImuStep {
  Eigen::Vector3d gyro_rad_s;
  Eigen::Vector3d accel_m_s2;
  double dt_s = 0.0;
};

// Returns the state `step.dt_s` later, exact for a constant rate and specific force in the body
// frame. Gravity is (0, 0, -gravity_m_s2) in local.
ImuState IntegrateImu(const ImuState& start, const ImuStep& step, double gravity_m_s2);

// The linearization point of the transition matrix: the first estimates. With them, the matrices of
// successive steps multiply to the matrix of the whole interval, and no unobservable direction
// seems observed (Huang, Mourikis and Roumeliotis 2010).
struct FirstEstimate {
  Eigen::Vector3d position_in_local = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_in_local = Eigen::Vector3d::Zero();
};

// Error at the end = phi * error at the start + noise with covariance `noise`.
struct ImuTransition {
  Matrix15d phi = Matrix15d::Identity();
  Matrix15d noise = Matrix15d::Zero();
  double duration_s = 0.0;
};

// Transition matrix of one step from `start` to `end` = IntegrateImu(start, step). The
// linearization uses the position and velocity of `first` instead of those of `start`.
Matrix15d TransitionMatrix(const ImuState& start, const FirstEstimate& first, const ImuState& end,
                           const ImuStep& step, double gravity_m_s2);

// Returns the covariance that one step adds to the error.
Matrix15d ProcessNoise(const ImuNoise& noise, double dt_s);

// Moves `state` and `first` over one step and appends the step to `transition`. Afterwards `first`
// equals the new state, which no measurement has updated yet. Allocates nothing.
void Propagate(const ImuStep& step, const ImuNoise& noise, double gravity_m_s2, ImuState* state,
               FirstEstimate* first, ImuTransition* transition);

}  // namespace cairn::fusion

#endif  // CAIRN_CORE_INERTIAL_IMU_PROPAGATION_H_
