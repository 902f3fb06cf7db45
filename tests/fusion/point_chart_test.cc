#include "fusion/filter/point_chart.h"

#include <gtest/gtest.h>

#include "support/numeric_jacobian.h"

namespace cairn::fusion {
namespace {

using cairn::testing::NumericJacobian;

class PointChartTest : public ::testing::Test {
 protected:
  Eigen::Vector3d center_ = {0.3, -0.2, 0.1};
  Eigen::Vector3d x_ = {4.0, 2.0, -1.0};
  PointChart chart_{center_, x_};
};

TEST_F(PointChartTest, OriginIsWhereItWasMade) {
  EXPECT_LT((chart_.ToPoint(chart_.origin()) - x_).norm(), 1e-12);
  EXPECT_NEAR(chart_.origin().z(), 1.0 / (x_ - center_).norm(), 1e-12);
}

TEST_F(PointChartTest, FromPointInvertsToPoint) {
  for (const Eigen::Vector3d& coordinates :
       {Eigen::Vector3d(0.0, 0.0, 0.25), Eigen::Vector3d(0.2, -0.1, 0.4),
        Eigen::Vector3d(-0.7, 0.5, 0.01)}) {
    EXPECT_LT((chart_.FromPoint(chart_.ToPoint(coordinates)) - coordinates).norm(), 1e-9);
  }
  for (const Eigen::Vector3d& x : {Eigen::Vector3d(5.0, 1.0, 0.0), Eigen::Vector3d(60.0, 9.0, 3.0),
                                   Eigen::Vector3d(0.6, 0.0, 0.0)}) {
    EXPECT_LT((chart_.ToPoint(chart_.FromPoint(x)) - x).norm(), 1e-9);
  }
}

TEST_F(PointChartTest, JacobianIsTheDerivativeOfToPoint) {
  const Eigen::Vector3d coordinates(0.2, -0.1, 0.4);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
    const Eigen::Vector3d numeric =
        (chart_.ToPoint(coordinates + step) - chart_.ToPoint(coordinates - step)) / (2.0 * kStep);
    EXPECT_LT((numeric - chart_.Jacobian(coordinates).col(i)).norm(), 1e-7) << "column " << i;
  }
}

TEST(PointChart, JacobianAgreesWithFiniteDifferences) {
  const Eigen::Vector3d x(4.0, -1.0, 2.0);
  const PointChart chart({1.0, 0.5, -0.3}, x);
  EXPECT_LT((chart.ToPoint(chart.origin()) - x).norm(), 1e-12);
  const Eigen::Vector3d coordinates = chart.origin() + Eigen::Vector3d(0.1, -0.2, 0.05);
  const auto numeric = NumericJacobian<3, 3>(
      [&](const Eigen::Vector3d& d) { return chart.ToPoint(coordinates + d); });
  EXPECT_LT((chart.Jacobian(coordinates) - numeric).norm(), 1e-5 * numeric.norm());
}

}  // namespace
}  // namespace cairn::fusion
