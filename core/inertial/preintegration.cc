#include "core/inertial/preintegration.h"

#include <Eigen/Cholesky>

namespace cairn::fusion {

Preintegration::Preintegration(const ImuNoise& noise, const Eigen::Vector3d& gyro_bias,
                               const Eigen::Vector3d& accel_bias)
    : noise_(noise) {
  delta_.gyro_bias = gyro_bias;
  delta_.accel_bias = accel_bias;
}

void Preintegration::Append(std::span<const ImuStep> steps) {
  steps_.insert(steps_.end(), steps.begin(), steps.end());
  Integrate(steps);
}

void Preintegration::Reintegrate(const Eigen::Vector3d& gyro_bias,
                                 const Eigen::Vector3d& accel_bias) {
  delta_ = ImuState();
  delta_.gyro_bias = gyro_bias;
  delta_.accel_bias = accel_bias;
  first_ = FirstEstimate();
  transition_ = ImuTransition();
  Integrate(steps_);
}

// Starting from rest and without gravity, the strapdown state is the preintegrated motion. The
// transition matrix then holds the derivatives by the biases, and the noise holds the covariance.
void Preintegration::Integrate(std::span<const ImuStep> steps) {
  for (const ImuStep& step : steps) {
    Propagate(step, noise_, /*gravity_m_s2=*/0.0, &delta_, &first_, &transition_);
  }
}

Matrix15d Preintegration::SqrtInformation() const {
  Matrix15d sqrt_information = Matrix15d::Identity();
  transition_.noise.llt().matrixL().solveInPlace(sqrt_information);
  return sqrt_information;
}

}  // namespace cairn::fusion
