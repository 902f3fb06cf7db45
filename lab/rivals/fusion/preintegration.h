// Preintegration of inertial samples between two cameras (Forster, Carlone, Dellaert and Scaramuzza
// 2017), on the filter's own strapdown integration.
#ifndef CAIRN_LAB_RIVALS_FUSION_PREINTEGRATION_H_
#define CAIRN_LAB_RIVALS_FUSION_PREINTEGRATION_H_

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fusion/filter/imu.h"
#include "fusion/filter/imu_propagation.h"

namespace cairn::fusion {

// Motion from instant i to instant j as the imu saw it, in the imu frame of i and without gravity,
// at fixed biases, with its derivatives by the biases and its covariance. Keeps the samples, so
// that neighbouring intervals can be merged when the camera between them is discarded.
class Preintegration {
 public:
  // Of nothing, at the given biases.
  Preintegration(const ImuNoise& noise, const Eigen::Vector3d& gyro_bias,
                 const Eigen::Vector3d& accel_bias);

  // Lengthens the interval at its end.
  void Append(std::span<const ImuStep> steps);

  // Integrates all samples anew, at other biases.
  void Reintegrate(const Eigen::Vector3d& gyro_bias, const Eigen::Vector3d& accel_bias);

  // local_from_imu is imu i from imu j, velocity that of j less that of i; biases are those
  // integrated at.
  const ImuState& delta() const { return delta_; }
  // d [theta, p, v] / d [b_g, b_a], theta on the left of delta's rotation.
  Eigen::Matrix<double, 9, 6> ByBiases() const { return transition_.phi.block<9, 6>(0, 9); }
  double duration_s() const { return transition_.duration_s; }
  std::span<const ImuStep> steps() const { return steps_; }

  // W with W' W the inverse of the covariance of [theta, p, v, b_g, b_a] at the end, the biases at
  // the start being known. Needs a positive duration.
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

#endif  // CAIRN_LAB_RIVALS_FUSION_PREINTEGRATION_H_
