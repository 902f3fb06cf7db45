#include "fusion/filter/measurement.h"

#include <gtest/gtest.h>

namespace cairn::fusion {
namespace {

TEST(Measurement, CompressionKeepsInformation) {
  Measurement measurement{{{0, 6}}, Eigen::MatrixXd::Random(40, 6), Eigen::VectorXd::Random(40)};
  const Eigen::MatrixXd information = measurement.jacobian.transpose() * measurement.jacobian;
  const Eigen::VectorXd vector = measurement.jacobian.transpose() * measurement.residual;
  Compress(&measurement);
  EXPECT_EQ(measurement.num_rows(), 6);
  EXPECT_TRUE((measurement.jacobian.transpose() * measurement.jacobian).isApprox(information));
  EXPECT_TRUE((measurement.jacobian.transpose() * measurement.residual).isApprox(vector));
}

}  // namespace
}  // namespace cairn::fusion
