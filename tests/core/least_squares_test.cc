#include "core/least_squares.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <optional>

namespace cairn {
namespace {

// Rosenbrock's valley as two residuals: 10 (y - x^2) and 1 - x.
std::optional<NormalSystem<2>> Valley(const Eigen::Vector2d& at) {
  const Eigen::Vector2d residual(10.0 * (at.y() - at.x() * at.x()), 1.0 - at.x());
  Eigen::Matrix2d jacobian;
  jacobian << -20.0 * at.x(), 10.0, -1.0, 0.0;
  return NormalSystem<2>{jacobian.transpose() * jacobian, jacobian.transpose() * residual,
                         residual.squaredNorm()};
}

Eigen::Vector2d Plus(const Eigen::Vector2d& at, const Eigen::Vector2d& step) { return at + step; }

TEST(LeastSquares, FollowsAValleyToItsEnd) {
  const auto minimum = MinimizeLeastSquares<2>(Eigen::Vector2d(-1.2, 1.0), Valley, Plus,
                                               {.max_steps = 100, .min_decrease = 1e-9});
  ASSERT_TRUE(minimum);
  EXPECT_TRUE(minimum->has_converged);
  EXPECT_LT((minimum->state - Eigen::Vector2d(1.0, 1.0)).norm(), 1e-4);
  EXPECT_LT(minimum->system.cost, 1e-8);
}

TEST(LeastSquares, SaysThatItHasNotConverged) {
  const auto minimum = MinimizeLeastSquares<2>(Eigen::Vector2d(-1.2, 1.0), Valley, Plus,
                                               {.max_steps = 3, .min_decrease = 1e-9});
  ASSERT_TRUE(minimum);
  EXPECT_FALSE(minimum->has_converged);
  EXPECT_LE(minimum->num_steps, 3);
  EXPECT_LT(minimum->system.cost, Valley(Eigen::Vector2d(-1.2, 1.0))->cost);
}

TEST(LeastSquares, StopsBeforeAStepThatPromisesLittle) {
  const Eigen::Vector2d near_the_end(1.0 + 1e-7, 1.0 + 2e-7);
  const auto minimum = MinimizeLeastSquares<2>(near_the_end, Valley, Plus,
                                               {.max_steps = 5, .min_predicted_decrease = 1e-4});
  ASSERT_TRUE(minimum);
  EXPECT_TRUE(minimum->has_converged);
  EXPECT_EQ(minimum->num_steps, 0);
  EXPECT_EQ(minimum->state, near_the_end);
}

// The problem is defined to the right of -0.5 only. Full steps from there would leave it.
TEST(LeastSquares, StaysWhereTheProblemIsDefined) {
  const auto right_half = [](const Eigen::Vector2d& at) {
    return at.x() > -0.5 ? Valley(at) : std::nullopt;
  };
  EXPECT_FALSE(MinimizeLeastSquares<2>(Eigen::Vector2d(-1.2, 1.0), right_half, Plus, {}));
  const auto minimum = MinimizeLeastSquares<2>(Eigen::Vector2d(-0.4, 3.0), right_half, Plus,
                                               {.max_steps = 100, .min_decrease = 1e-9});
  ASSERT_TRUE(minimum);
  EXPECT_LT((minimum->state - Eigen::Vector2d(1.0, 1.0)).norm(), 1e-4);
}

// Only the sum of the parameters is observed.
TEST(LeastSquares, LeavesAnUnobservedDirectionAlone) {
  const auto sum_is_three = [](const Eigen::Vector2d& at) -> std::optional<NormalSystem<2>> {
    const Eigen::RowVector2d jacobian(1.0, 1.0);
    const double residual = at.sum() - 3.0;
    return NormalSystem<2>{jacobian.transpose() * jacobian, jacobian.transpose() * residual,
                           residual * residual};
  };
  const auto minimum =
      MinimizeLeastSquares<2>(Eigen::Vector2d(2.0, 0.0), sum_is_three, Plus,
                              {.max_steps = 20, .diagonal_floor = 1e-9, .min_decrease = 1e-9});
  ASSERT_TRUE(minimum);
  EXPECT_NEAR(minimum->state.sum(), 3.0, 1e-4);
  EXPECT_NEAR(minimum->state.x() - minimum->state.y(), 2.0, 1e-4);
}

}  // namespace
}  // namespace cairn
