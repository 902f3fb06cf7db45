#include "eval/recordings/figure_of_eight.h"

#include <gtest/gtest.h>

namespace cairn::fusion {
namespace {

TEST(FigureOfEight, ItsDerivativesAreThoseOfItsPath) {
  const FigureOfEight walk({.seed = 3, .start_stop_s = {1.0, 6.0}});
  const Motion by_differences =
      MotionAlong([&walk](double time_s) { return walk.At(time_s).world_from_imu; });
  for (const double time_s : {1.3, 1.7, 3.0, 5.5, 6.4}) {  // Starting, walking, stopping.
    const MotionState exact = walk.At(time_s);
    const MotionState differences = by_differences(time_s);
    EXPECT_LT((differences.velocity_in_world - exact.velocity_in_world).norm(), 1e-8) << time_s;
    EXPECT_LT((differences.acceleration_in_world - exact.acceleration_in_world).norm(), 1e-6)
        << time_s;
    EXPECT_LT((differences.rate_in_imu - exact.rate_in_imu).norm(), 1e-6) << time_s;
  }
}

TEST(FigureOfEight, StandsUntilItStartsAndOnceItHasStopped) {
  const FigureOfEight walk({.start_stop_s = {1.0, 6.0}});
  EXPECT_EQ(walk.At(0.5).velocity_in_world.norm(), 0.0);
  EXPECT_GT(walk.At(4.0).velocity_in_world.norm(), 0.5);
  EXPECT_LT(walk.At(7.5).velocity_in_world.norm(), 1e-12);
  EXPECT_LT(
      (walk.At(9.0).world_from_imu.translation - walk.At(7.5).world_from_imu.translation).norm(),
      1e-12);
}

}  // namespace
}  // namespace cairn::fusion
