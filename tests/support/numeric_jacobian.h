// Computes Jacobians by central differences, for comparison with analytic ones.
#ifndef CAIRN_TESTS_SUPPORT_NUMERIC_JACOBIAN_H_
#define CAIRN_TESTS_SUPPORT_NUMERIC_JACOBIAN_H_

#include <Eigen/Core>

namespace cairn::testing {

// Returns d f(x (+) delta) / d delta at delta = 0. `f` takes delta, a vector of kNumParams, and
// returns a vector of kNumResiduals. The error is of the order of step^2.
template <int kNumResiduals, int kNumParams, typename Function>
Eigen::Matrix<double, kNumResiduals, kNumParams> NumericJacobian(const Function& f,
                                                                 double step = 1e-5) {
  Eigen::Matrix<double, kNumResiduals, kNumParams> jacobian;
  for (int i = 0; i < kNumParams; ++i) {
    Eigen::Matrix<double, kNumParams, 1> delta = Eigen::Matrix<double, kNumParams, 1>::Zero();
    delta[i] = step;
    jacobian.col(i) = (f(delta) - f(-delta)) / (2.0 * step);
  }
  return jacobian;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_NUMERIC_JACOBIAN_H_
