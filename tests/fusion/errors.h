// Computes an estimator's errors against the truth of a simulation.
#ifndef CAIRN_TESTS_FUSION_ERRORS_H_
#define CAIRN_TESTS_FUSION_ERRORS_H_

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

#include "fusion/filter/filter_state.h"
#include "fusion/simulation.h"

namespace cairn::fusion::testing {

// Returns [theta, p, v, b_g, b_a] as truth minus estimate, with the perturbation of FilterState.
inline Vector15d ImuError(const ImuState& estimate, const FrameTruth& truth,
                          const Rigid3d& local_from_world) {
  return Difference(
      {local_from_world * truth.world_from_imu, local_from_world.rotation * truth.velocity_in_world,
       truth.gyro_bias, truth.accel_bias},
      estimate);
}

// Returns [rho, psi] of global_from_local.
inline Eigen::Vector4d GlobalError(const Rigid3d& global_from_local,
                                   const Rigid3d& local_from_world) {
  const Rigid3d error = global_from_local.Inverse() * local_from_world.Inverse();
  const Eigen::Vector3d rotation = LogSo3(error.rotation);
  return {error.translation.x(), error.translation.y(), error.translation.z(), rotation.z()};
}

// Returns the normalized estimation error squared, per degree of freedom.
template <typename Error, typename Covariance>
double Nees(const Error& error, const Covariance& covariance) {
  const Eigen::MatrixXd matrix = covariance;
  const Eigen::VectorXd vector = error;
  return vector.dot(matrix.ldlt().solve(vector)) / static_cast<double>(vector.size());
}

// The root mean square of the added values.
class Rms {
 public:
  void Add(double value) {
    sq_sum_ += value * value;
    ++count_;
  }
  double Value() const { return count_ == 0 ? 0.0 : std::sqrt(sq_sum_ / count_); }

 private:
  double sq_sum_ = 0.0;
  int count_ = 0;
};

}  // namespace cairn::fusion::testing

#endif  // CAIRN_TESTS_FUSION_ERRORS_H_
