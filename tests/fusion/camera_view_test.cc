#include "fusion/filter/camera_view.h"

#include <gtest/gtest.h>

#include <vector>

#include "fusion/map_updates/map_update.h"
#include "fusion/moving_state.h"
#include "fusion/perturb.h"
#include "fusion/tracks/track_update.h"
#include "support/cameras.h"
#include "support/numeric_jacobian.h"

namespace cairn::fusion {
namespace {

using cairn::testing::NumericJacobian;
using testing::PerturbGlobal;
using testing::PerturbLeft;
using testing::SomeState;
using testing::Vector6d;

class JacobianTest : public ::testing::TestWithParam<int> {
 protected:
  JacobianTest()
      : camera_(cairn::testing::OneCameraPerModel()[static_cast<size_t>(GetParam())]),
        state_(SomeState(1)),
        view_(state_.rig(), state_.clones()[0]),
        x_in_local_(view_.center_in_local +
                    view_.cam_from_local_rotation.transpose() * Eigen::Vector3d(0.7, -0.5, 4.0)),
        predicted_(*PredictPixel(camera_, view_, x_in_local_)) {}

  Eigen::Vector2d PixelAt(const Rig& rig, const Rigid3d& local_from_imu,
                          const Eigen::Vector3d& x_in_local) const {
    Clone clone = state_.clones()[0];
    clone.local_from_imu = local_from_imu;
    return PredictPixel(camera_, CameraView(rig, clone), x_in_local)->pixel;
  }

  Camera camera_;
  FilterState state_;
  CameraView view_;
  Eigen::Vector3d x_in_local_;
  PredictedPixel predicted_;
};

TEST_P(JacobianTest, ByPoint) {
  const auto numeric = NumericJacobian<2, 3>([&](const Eigen::Vector3d& d) {
    return PixelAt(state_.rig(), state_.clones()[0].local_from_imu, x_in_local_ + d);
  });
  EXPECT_LT((predicted_.by_local - numeric).norm(), 1e-5 * numeric.norm());
}

TEST_P(JacobianTest, ByClone) {
  const auto numeric = NumericJacobian<2, 6>([&](const Vector6d& d) {
    return PixelAt(state_.rig(), PerturbLeft(state_.clones()[0].local_from_imu, d), x_in_local_);
  });
  EXPECT_LT((ByClone(predicted_, view_, x_in_local_) - numeric).norm(), 1e-5 * numeric.norm());
}

TEST_P(JacobianTest, ByGlobal) {
  const Rigid3d global_from_local(ExpSo3({0.0, 0.0, 0.8}), Eigen::Vector3d(30.0, -20.0, 5.0));
  const Eigen::Vector3d x_in_global = global_from_local * x_in_local_;
  const auto numeric = NumericJacobian<2, 6>([&](const Vector6d& d) {
    return PixelAt(state_.rig(), state_.clones()[0].local_from_imu,
                   PerturbGlobal(global_from_local, d).Inverse() * x_in_global);
  });
  EXPECT_LT((ByGlobal(predicted_, x_in_local_) - numeric).norm(), 1e-5 * numeric.norm());
}

TEST_P(JacobianTest, ByRig) {
  const auto numeric = NumericJacobian<2, 6>([&](const Vector6d& d) {
    const Rig moved{PerturbLeft(state_.rig().cam_from_imu, d), 0.0};
    return PixelAt(moved, state_.clones()[0].local_from_imu, x_in_local_);
  });
  const auto analytic = ByRig(predicted_, state_.rig());
  EXPECT_LT((analytic.leftCols<6>() - numeric).norm(), 1e-5 * numeric.norm());
  EXPECT_TRUE(analytic.col(6).isZero());  // The clone carries it.
}

TEST_P(JacobianTest, MapRowsKnowNothingOfUnobservableDirections) {
  const Rigid3d global_from_local(ExpSo3({0.0, 0.0, 0.8}), Eigen::Vector3d(30.0, -20.0, 5.0));
  const MapObservation observation{0, 0, {100.0, 100.0}, global_from_local * x_in_local_, 0.05, 1};
  const std::vector<CameraView> views = ViewsOfClones(state_);
  const auto rows =
      LinearizeObservation(camera_, state_.rig(), views, global_from_local, observation, 1.0);
  ASSERT_TRUE(rows.has_value());
  // A shift of local moves clones by d and rho by -d; a turn by e_z turns the clones, psi by -1.
  Eigen::Matrix<double, 2, 3> shift = rows->by_clone.rightCols<3>() - rows->by_global.leftCols<3>();
  EXPECT_LT(shift.norm(), 1e-9);
  Vector6d turn;
  turn << Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ().cross(view_.first_position_in_local);
  EXPECT_LT((rows->by_clone * turn - rows->by_global.col(3)).norm(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Cameras, JacobianTest, ::testing::Range(0, 6));

}  // namespace
}  // namespace cairn::fusion
