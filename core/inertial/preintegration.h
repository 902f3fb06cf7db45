// Preintegrates inertial samples between two cameras (Forster, Carlone, Dellaert and Scaramuzza
// 2017). Uses the filter's strapdown integration.
#ifndef CAIRN_CORE_INERTIAL_PREINTEGRATION_H_
#define CAIRN_CORE_INERTIAL_PREINTEGRATION_H_

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/inertial/imu.h"
#include "core/inertial/imu_propagation.h"

namespace cairn::fusion {

// The motion from time i to time j that the IMU measured at fixed biases, in the IMU frame of i and
// without gravity. Includes the derivatives by the biases and the covariance. Keeps the samples, so
// that two adjacent intervals can be merged when the camera between them is discarded.
class Preintegration {
 public:
  // An empty interval at the given biases.
  Preintegration(const ImuNoise& noise, const Eigen::Vector3d& gyro_bias,
                 const Eigen::Vector3d& accel_bias);

  // Extends the interval at its end.
  void Append(std::span<const ImuStep> steps);

  // Integrates all samples again, at other biases.
  void Reintegrate(const Eigen::Vector3d& gyro_bias, const Eigen::Vector3d& accel_bias);

  // local_from_imu is the pose of imu j in the frame of imu i. The velocity is that of j minus that
  // of i. The biases are those of the integration.
  const ImuState& delta() const { return delta_; }
  // d [theta, p, v] / d [b_g, b_a], with theta on the left of delta's rotation.
  Eigen::Matrix<double, 9, 6> ByBiases() const { return transition_.phi.block<9, 6>(0, 9); }
  double duration_s() const { return transition_.duration_s; }
  std::span<const ImuStep> steps() const { return steps_; }

  // Returns W such that W' W is the inverse of the covariance of [theta, p, v, b_g, b_a] at the
  // end, given the biases at the start. The duration must be positive.
  Matrix15d SqrtInformation() const;

 private:
  void Integrate(std::span<const ImuStep> steps);

  ImuNoise noise_;
  std::vector<ImuStep> steps_;
  ImuState delta_;
  FirstEstimate first_;
  ImuTransition transition_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_CORE_INERTIAL_PREINTEGRATION_H_
