// The radius that holds 68 % of a Gaussian. Cairn states all accuracies of positions and rotations
// this way, as GPS receivers do.
#ifndef CAIRN_CORE_RADIUS68_H_
#define CAIRN_CORE_RADIUS68_H_

#include <Eigen/Core>
#include <cmath>

namespace cairn {

// Radii per standard deviation of an axis, for isotropic Gaussians: square roots of the 0.68
// quantiles of chi-squared with two degrees of freedom (-2 ln 0.32) and with three.
inline constexpr double kRadius68PerSigma2d = 1.5095921854516636;
inline constexpr double kRadius68PerSigma3d = 1.8724001590921162;

// Returns the radius of an isotropic Gaussian in space whose covariance has this trace.
inline double Radius68(const Eigen::Matrix3d& covariance) {
  return kRadius68PerSigma3d * std::sqrt(covariance.trace() / 3.0);
}

}  // namespace cairn

#endif  // CAIRN_CORE_RADIUS68_H_
