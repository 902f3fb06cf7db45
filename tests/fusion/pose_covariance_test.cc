#include "fusion/filter/pose_covariance.h"

#include <gtest/gtest.h>

#include "fusion/perturb.h"
#include "support/numeric_jacobian.h"

namespace cairn::fusion {
namespace {

using cairn::testing::NumericJacobian;
using testing::PerturbGlobal;
using testing::PerturbLeft;
using testing::Vector6d;

TEST(PoseCovariance, GlobalPoseJacobianAgreesWithFiniteDifferences) {
  const Rigid3d global_from_local(ExpSo3({0.02, -0.01, 0.8}), Eigen::Vector3d(30.0, -20.0, 5.0));
  const Rigid3d local_from_imu(ExpSo3({0.4, 0.3, -0.8}), Eigen::Vector3d(3.0, 2.0, -1.0));
  const Rigid3d pose = global_from_local * local_from_imu;
  const auto numeric =
      NumericJacobian<6, 12>([&](const Eigen::Matrix<double, 12, 1>& d) -> Vector6d {
        const Rigid3d moved = PerturbGlobal(global_from_local, d.tail<6>()) *
                              PerturbLeft(local_from_imu, d.head<6>());
        Vector6d error;
        error << LogSo3(moved.rotation * pose.rotation.conjugate()),
            moved.translation - pose.translation;
        return error;
      });
  EXPECT_LT((GlobalPoseJacobian(global_from_local, local_from_imu) - numeric).norm(), 1e-6);
}

}  // namespace
}  // namespace cairn::fusion
