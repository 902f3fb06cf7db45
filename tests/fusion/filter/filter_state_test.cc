#include "fusion/filter/filter_state.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "fusion/filter/camera_view.h"
#include "fusion/filter/pose_covariance.h"
#include "fusion/map_updates/map_update.h"
#include "fusion/tracks/track_update.h"
#include "support/cameras.h"
#include "support/numeric_jacobian.h"

namespace cairn::fusion {
namespace {

using cairn::testing::NumericJacobian;
using Vector6d = Eigen::Matrix<double, 6, 1>;

Rig SomeRig() {
  return {Rigid3d(ExpSo3({1.2, -1.1, 1.3}), Eigen::Vector3d(0.03, 0.01, -0.05)), 0.0};
}

// A state with `num_clones` correlated clones on a curve.
FilterState SomeState(int num_clones, const FilterStateOptions& options = {}) {
  ImuState imu;
  imu.local_from_imu = Rigid3d(ExpSo3({0.1, -0.2, 0.5}), Eigen::Vector3d(1.0, 2.0, 3.0));
  imu.velocity_in_local = {0.5, 1.0, -0.2};
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, 0.05);
  const Matrix15d root = Matrix15d::NullaryExpr([&] { return normal(random); });
  FilterState state(imu, root * root.transpose(), SomeRig(), options);
  FirstEstimate first = state.first();
  for (int i = 0; i < num_clones; ++i) {
    ImuState end = state.imu();
    ImuTransition transition;
    for (int k = 0; k < 20; ++k) {
      Propagate({{0.3, 0.2, 0.5}, {0.5, 0.3, 9.8}, 0.005}, ImuNoise(), 9.81, &end, &first,
                &transition);
    }
    state.Propagate(end, first, transition);
    state.AddClone(i + 1, i, {0.3, 0.2, 0.5});
  }
  return state;
}

Eigen::VectorXd RandomVector(int size, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(size, [&] { return normal(random); });
}

// What a track seen by the first three clones says about its point.
PointRows SomePointRows(const FilterState& state) {
  return {{4.0, 1.0, 2.0},
          Eigen::Matrix3d{{2.0, 0.4, -0.3}, {0.0, 1.5, 0.7}, {0.0, 0.0, 1.0}},
          {{{state.CloneIdx(0), 18}},
           RandomVector(3 * 18, 5).reshaped(3, 18),
           0.01 * RandomVector(3, 6)}};
}

// The error of the state with that of a point in local in place of that of its coordinates.
Eigen::MatrixXd InLocal(const FilterState& state, int slot) {
  const LocatedPoint located = state.Locate(slot);
  Eigen::MatrixXd by_state = Eigen::MatrixXd::Identity(state.dim(), state.dim());
  const int point = state.PointIdx(slot);
  by_state.block<3, 3>(point, point) = located.by_coordinates;
  by_state.block<3, 6>(point, state.CloneIdx(state.points()[static_cast<size_t>(slot)]->anchor)) =
      located.by_anchor;
  return by_state;
}

Rigid3d PerturbLeft(const Rigid3d& pose, const Vector6d& error) {
  Rigid3d moved = pose;
  moved.rotation = ExpSo3(error.head<3>()) * pose.rotation;
  moved.translation += error.tail<3>();
  return moved;
}

Rigid3d PerturbGlobal(const Rigid3d& global_from_local, const Vector6d& error) {
  return global_from_local * Rigid3d(ExpSo3({error[4], error[5], error[3]}), error.head<3>());
}

TEST(FilterState, ACloneIsACopyOfThePose) {
  const FilterState state = SomeState(2);
  const int newest = state.CloneIdx(1);
  const auto covariance = state.covariance();
  EXPECT_TRUE((covariance.block<6, 6>(newest, newest).isApprox(covariance.block<6, 6>(0, 0))));
  EXPECT_TRUE((covariance.block<15, 6>(0, newest).isApprox(covariance.block<15, 6>(0, 0))));
  EXPECT_TRUE(covariance.isApprox(covariance.transpose(), 1e-14));
}

TEST(FilterState, ACloneMovesWithTheTimeOffset) {
  FilterStateOptions options;
  options.time_offset_sigma_s = 0.01;
  const FilterState state = SomeState(1, options);
  Vector6d by_time;
  by_time << state.imu().local_from_imu.rotation * Eigen::Vector3d(0.3, 0.2, 0.5),
      state.imu().velocity_in_local;
  const int clone = state.CloneIdx(0);
  const Eigen::MatrixXd covariance = state.covariance();
  EXPECT_TRUE((covariance.block<6, 1>(clone, kRigIdx + 6).isApprox(by_time * 1e-4)));
  EXPECT_TRUE((covariance.block<6, 6>(clone, clone))
                  .isApprox(covariance.block<6, 6>(0, 0) + by_time * 1e-4 * by_time.transpose()));
}

TEST(FilterState, RemovingACloneMarginalisesIt) {
  FilterState state = SomeState(4);
  const Eigen::MatrixXd before = state.covariance();
  const int removed = state.CloneIdx(1);
  state.RemoveClone(1);
  ASSERT_EQ(state.dim(), before.rows() - kCloneDim);
  const int after = state.dim() - removed;
  const Eigen::MatrixXd now = state.covariance();
  EXPECT_EQ(now.topLeftCorner(removed, removed), before.topLeftCorner(removed, removed));
  EXPECT_EQ(now.bottomRightCorner(after, after), before.bottomRightCorner(after, after));
  EXPECT_EQ(now.topRightCorner(removed, after), before.topRightCorner(removed, after));
  EXPECT_EQ(state.clones()[1].frame_id, 3);
}

TEST(FilterState, UpdateIsThatOfKalman) {
  FilterState state = SomeState(3);
  const Eigen::MatrixXd p = state.covariance();
  Measurement measurement;
  measurement.blocks = {{state.CloneIdx(2), 6}, {kVelocityIdx, 3}};
  measurement.jacobian = RandomVector(7 * 9, 5).reshaped(7, 9);
  measurement.residual = 0.01 * RandomVector(7, 6);
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(7, p.rows());
  h.middleCols(state.CloneIdx(2), 6) = measurement.jacobian.leftCols(6);
  h.middleCols(kVelocityIdx, 3) = measurement.jacobian.rightCols(3);
  const Eigen::MatrixXd s = h * p * h.transpose() + Eigen::MatrixXd::Identity(7, 7);
  const Eigen::MatrixXd k = p * h.transpose() * s.inverse();
  const Eigen::MatrixXd i_kh = Eigen::MatrixXd::Identity(p.rows(), p.rows()) - k * h;
  const Eigen::Vector3d velocity = state.imu().velocity_in_local;
  EXPECT_NEAR(state.SquaredMahalanobis(measurement),
              measurement.residual.dot(s.inverse() * measurement.residual), 1e-12);
  ASSERT_TRUE(state.Update(measurement));
  const Eigen::MatrixXd joseph = i_kh * p * i_kh.transpose() + k * k.transpose();
  EXPECT_LT((state.covariance() - joseph).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((state.imu().velocity_in_local - velocity -
             (k * measurement.residual).segment<3>(kVelocityIdx))
                .norm(),
            1e-12);
}

TEST(FilterState, AnInfiniteResidualChangesNothing) {
  FilterState state = SomeState(2);
  const Eigen::MatrixXd before = state.covariance();
  Measurement measurement{
      {{0, 3}}, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Constant(std::nan(""))};
  EXPECT_FALSE(state.Update(measurement));
  EXPECT_EQ(Eigen::MatrixXd(state.covariance()), before);
}

TEST(FilterState, TilesAreConsideredButNotCorrected) {
  FilterStateOptions options;
  options.tile_sigma_m = 0.2;
  FilterState state = SomeState(2, options);
  const int tile = state.TileIdx(77);
  Measurement measurement{{{state.CloneIdx(0), 6}, {tile, 3}},
                          Eigen::MatrixXd::Random(5, 9),
                          Eigen::VectorXd::Constant(5, 0.1)};
  ASSERT_TRUE(state.Update(measurement));
  EXPECT_TRUE(
      (state.covariance().block<3, 3>(tile, tile)).isApprox(0.04 * Eigen::Matrix3d::Identity()));
  EXPECT_GT((state.covariance().block<6, 3>(state.CloneIdx(0), tile)).norm(), 1e-4);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(state.covariance());
  EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-12);
}

TEST(FilterState, InitializingGlobalIsAnUpdateWithoutPrior) {
  // The reference: global_from_local with a standard deviation of 100 (m, rad), updated.
  FilterStateOptions options;
  options.max_points = 0;
  FilterState state = SomeState(3, options);
  const Eigen::MatrixXd p = state.covariance();
  Measurement measurement{{{kGlobalIdx, 4}, {state.CloneIdx(0), 18}},
                          RandomVector(30 * 22, 9).reshaped(30, 22),
                          0.01 * RandomVector(30, 10)};
  Eigen::MatrixXd prior = p;
  prior.diagonal().segment<4>(kGlobalIdx).setConstant(1e4);
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(30, p.rows());
  h.middleCols(kGlobalIdx, 4) = measurement.jacobian.leftCols(4);
  h.middleCols(state.CloneIdx(0), 18) = measurement.jacobian.rightCols(18);
  const Eigen::MatrixXd s = h * prior * h.transpose() + Eigen::MatrixXd::Identity(30, 30);
  const Eigen::MatrixXd gain = prior * h.transpose() * s.inverse();
  const Eigen::MatrixXd expected = prior - gain * s * gain.transpose();
  ASSERT_TRUE(state.InitializeGlobal(Rigid3d(), measurement));
  EXPECT_LT((state.covariance() - expected).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT((state.global_from_local()->translation -
             (gain * measurement.residual).segment<3>(kGlobalIdx))
                .norm(),
            1e-3);
}

TEST(FilterState, EnteringAPointIsAnUpdateWithoutPrior) {
  // The reference: the point with a standard deviation of 1 km, updated.
  FilterState state = SomeState(3);
  Eigen::MatrixXd prior = state.covariance();
  const PointRows rows = SomePointRows(state);
  const int point = state.PointIdx(2);
  prior.diagonal().segment<3>(point).setConstant(1e6);
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(3, prior.rows());
  h.middleCols(point, 3) = rows.by_point;
  h.middleCols(state.CloneIdx(0), 18) = rows.clones.jacobian;
  const Eigen::MatrixXd s = h * prior * h.transpose() + Eigen::MatrixXd::Identity(3, 3);
  const Eigen::MatrixXd gain = prior * h.transpose() * s.inverse();
  const Eigen::MatrixXd expected = prior - gain * s * gain.transpose();
  // The covariance is that of the coordinates at the point of linearisation, where no residual
  // moves them from.
  FilterState unmoved = state;
  PointRows without_residual = rows;
  without_residual.clones.residual.setZero();
  ASSERT_TRUE(unmoved.EnterPoint(2, 77, without_residual));
  const Eigen::MatrixXd by_state = InLocal(unmoved, 2);
  EXPECT_LT(
      (by_state * unmoved.covariance() * by_state.transpose() - expected).cwiseAbs().maxCoeff(),
      1e-4);
  ASSERT_TRUE(state.EnterPoint(2, 77, rows));
  EXPECT_EQ(Eigen::MatrixXd(state.covariance()), Eigen::MatrixXd(unmoved.covariance()));
  EXPECT_EQ(state.points()[2]->track_id, 77u);
  EXPECT_LT((unmoved.Locate(2).x_in_local - rows.x_in_local).norm(), 1e-12);
  const Eigen::Vector3d correction =
      unmoved.Locate(2).by_coordinates *
      (state.points()[2]->coordinates - unmoved.points()[2]->coordinates);
  EXPECT_LT((correction - (gain * rows.clones.residual).segment<3>(point)).norm(), 1e-3);
}

TEST(FilterState, APointMovesWithItsAnchorAndItsCoordinates) {
  FilterState state = SomeState(3);
  PointRows rows = SomePointRows(state);
  rows.clones.residual.setZero();  // The first estimate is then the present one.
  ASSERT_TRUE(state.EnterPoint(2, 77, rows));
  const LocatedPoint located = state.Locate(2);
  const auto moved_by = [&](int offset, const Eigen::VectorXd& error) -> Eigen::Vector3d {
    FilterState moved = state;
    Correction correction{Eigen::VectorXd::Zero(state.dim()),
                          Eigen::MatrixXd::Zero(1, state.dim())};
    correction.error.segment(offset, error.size()) = error;
    moved.Apply(correction);
    return moved.Locate(2).x_in_local;
  };
  const auto by_anchor = NumericJacobian<3, 6>(
      [&](const Vector6d& error) { return moved_by(state.CloneIdx(2), error); });
  EXPECT_LT((located.by_anchor - by_anchor).norm(), 1e-5 * by_anchor.norm());
  const auto by_coordinates = NumericJacobian<3, 3>(
      [&](const Eigen::Vector3d& error) { return moved_by(state.PointIdx(2), error); }, 1e-6);
  EXPECT_LT((located.by_coordinates - by_coordinates).norm(), 1e-5 * by_coordinates.norm());
}

TEST(FilterState, APointTurnsWithLocalWhereverCorrectionsHaveMovedIt) {
  FilterState state = SomeState(3);
  ASSERT_TRUE(state.EnterPoint(2, 77, SomePointRows(state)));
  state.Apply({0.05 * RandomVector(state.dim(), 8), Eigen::MatrixXd::Zero(1, state.dim())});
  const LocatedPoint located = state.Locate(2);
  Vector6d turn;
  turn << Eigen::Vector3d::UnitZ(),
      Eigen::Vector3d::UnitZ().cross(state.clones()[2].first_position_in_local);
  EXPECT_LT(
      (located.by_anchor * turn - Eigen::Vector3d::UnitZ().cross(located.first_x_in_local)).norm(),
      1e-12);
}

TEST(FilterState, APointMovesToAnotherAnchorWhenItsCloneIsRemoved) {
  FilterState state = SomeState(3);
  ASSERT_TRUE(state.EnterPoint(2, 77, SomePointRows(state)));
  const Eigen::Vector3d x_in_local = state.Locate(2).x_in_local;
  const Eigen::MatrixXd by_state = InLocal(state, 2);
  const Eigen::MatrixXd before = by_state * state.covariance() * by_state.transpose();
  EXPECT_EQ(state.points()[2]->anchor, 2);
  state.RemoveClone(2);
  EXPECT_EQ(state.points()[2]->anchor, 1);
  EXPECT_LT((state.Locate(2).x_in_local - x_in_local).norm(), 1e-12);
  const Eigen::MatrixXd by_new_state = InLocal(state, 2);
  const Eigen::MatrixXd after = by_new_state * state.covariance() * by_new_state.transpose();
  EXPECT_TRUE(after.isApprox(before.topLeftCorner(state.dim(), state.dim()), 1e-9));
  state.RemoveClone(0);  // The anchor is what it was, at another place.
  EXPECT_EQ(state.points()[2]->anchor, 0);
  EXPECT_LT((state.Locate(2).x_in_local - x_in_local).norm(), 1e-12);
  state.RemoveClone(0);
  EXPECT_FALSE(state.points()[2].has_value());
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

TEST(FilterState, ARemovedPointLeavesNothing) {
  FilterState state = SomeState(3);
  const Eigen::MatrixXd before = state.covariance();
  PointRows rows{{4.0, 1.0, 2.0},
                 Eigen::Matrix3d::Identity(),
                 {{{state.CloneIdx(0), 18}},
                  RandomVector(3 * 18, 5).reshaped(3, 18),
                  Eigen::Vector3d::Zero()}};
  ASSERT_TRUE(state.EnterPoint(0, 77, rows));
  state.RemovePoint(0);
  EXPECT_EQ(Eigen::MatrixXd(state.covariance()), before);
  EXPECT_FALSE(state.points()[0].has_value());
}

TEST(FilterState, RefusesAnUndeterminedGlobal) {
  FilterState state = SomeState(1);
  Measurement measurement{{{kGlobalIdx, 4}, {state.CloneIdx(0), 6}},
                          Eigen::MatrixXd::Random(12, 10),
                          Eigen::VectorXd::Zero(12)};
  measurement.jacobian.col(3).setZero();
  EXPECT_FALSE(state.InitializeGlobal(Rigid3d(), measurement));
  EXPECT_FALSE(state.global_from_local().has_value());
}

TEST(Measurement, CompressionKeepsInformation) {
  Measurement measurement{{{0, 6}}, Eigen::MatrixXd::Random(40, 6), Eigen::VectorXd::Random(40)};
  const Eigen::MatrixXd information = measurement.jacobian.transpose() * measurement.jacobian;
  const Eigen::VectorXd vector = measurement.jacobian.transpose() * measurement.residual;
  Compress(&measurement);
  EXPECT_EQ(measurement.num_rows(), 6);
  EXPECT_TRUE((measurement.jacobian.transpose() * measurement.jacobian).isApprox(information));
  EXPECT_TRUE((measurement.jacobian.transpose() * measurement.residual).isApprox(vector));
}

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
  const MapSight sight{0, 0, {100.0, 100.0}, global_from_local * x_in_local_, 0.05, 1};
  const std::vector<CameraView> views = ViewsOfClones(state_);
  const auto rows = LinearizeSight(camera_, state_.rig(), views, global_from_local, sight, 1.0);
  ASSERT_TRUE(rows.has_value());
  // A shift of local moves clones by d and rho by -d; a turn by e_z turns the clones, psi by -1.
  Eigen::Matrix<double, 2, 3> shift = rows->by_clone.rightCols<3>() - rows->by_global.leftCols<3>();
  EXPECT_LT(shift.norm(), 1e-9);
  Vector6d turn;
  turn << Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ().cross(view_.first_position_in_local);
  EXPECT_LT((rows->by_clone * turn - rows->by_global.col(3)).norm(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Cameras, JacobianTest, ::testing::Range(0, 6));

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

// With offsets of tiles or without.
class MapUpdate : public ::testing::TestWithParam<bool> {};

TEST_P(MapUpdate, CompressedRowsHoldTheInformationOfAll) {
  FilterStateOptions options;
  options.tile_sigma_m = GetParam() ? 0.1 : 0.0;
  FilterState state = SomeState(4, options);
  const Camera camera = cairn::testing::OneCameraPerModel()[1];
  const std::vector<CameraView> views = ViewsOfClones(state);
  const Rigid3d global_from_local(ExpSo3({0.0, 0.0, 0.3}), Eigen::Vector3d(1.0, 2.0, 3.0));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<MapSight> sights;
  for (int i = 0; i < 60; ++i) {
    const auto& view = views[static_cast<size_t>(i % 4)];
    const double depth_m = 6.0 + 3.0 * uniform(random);
    const Eigen::Vector3d x =
        view.center_in_local +
        view.cam_from_local_rotation.transpose() *
            Eigen::Vector3d(0.4 * uniform(random), 0.3 * uniform(random), 1.0) * depth_m;
    sights.push_back({i,
                      i % 4,
                      {300.0 + 20.0 * uniform(random), 200.0},
                      global_from_local * x,
                      0.02,
                      static_cast<uint64_t>(i % 2)});
  }
  AddTiles(sights, &state);
  std::vector<MapRows> rows;
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(120, state.dim());
  Eigen::VectorXd r(120);
  for (size_t i = 0; i < sights.size(); ++i) {
    rows.push_back(*LinearizeSight(camera, state.rig(), views, global_from_local, sights[i], 1.0));
    const auto row = static_cast<Eigen::Index>(2 * i);
    h.block<2, 6>(row, state.CloneIdx(rows[i].clone)) = rows[i].by_clone;
    h.block<2, 4>(row, kGlobalIdx) = rows[i].by_global.leftCols<4>();
    if (state.has_tiles()) {
      h.block<2, 3>(row, *state.FindTileIdx(rows[i].tile_id)) = rows[i].by_tile;
    }
    r.segment<2>(row) = rows[i].residual;
  }
  const Measurement compressed = CompressMapRows(rows, 4, state);
  EXPECT_EQ(compressed.num_rows(), 4 * 6 + (state.has_tiles() ? 4 + 2 * 3 : 0));
  Eigen::MatrixXd hc = Eigen::MatrixXd::Zero(compressed.num_rows(), state.dim());
  Eigen::Index column = 0;
  for (const StateBlock& block : compressed.blocks) {
    hc.middleCols(block.offset, block.size) = compressed.jacobian.middleCols(column, block.size);
    column += block.size;
  }
  EXPECT_TRUE((hc.transpose() * hc).isApprox(h.transpose() * h, 1e-9));
  EXPECT_TRUE((hc.transpose() * compressed.residual).isApprox(h.transpose() * r, 1e-9));
}
INSTANTIATE_TEST_SUITE_P(Tiles, MapUpdate, ::testing::Bool());

}  // namespace
}  // namespace cairn::fusion
