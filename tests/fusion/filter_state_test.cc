#include "fusion/filter/filter_state.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <random>

#include "fusion/moving_state.h"
#include "support/numeric_jacobian.h"

namespace cairn::fusion {
namespace {

using cairn::testing::NumericJacobian;
using testing::SomeState;
using Vector6d = Eigen::Matrix<double, 6, 1>;

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

// The covariance of that error.
Eigen::MatrixXd InLocalCovariance(const FilterState& state, int slot) {
  const Eigen::MatrixXd by_state = InLocal(state, slot);
  const Eigen::MatrixXd covariance = state.covariance();
  const Eigen::MatrixXd moved = by_state * covariance;
  return moved * by_state.transpose();
}

// The update of `prior` by rows `h` with white noise of unit variance, as textbooks have it.
struct KalmanReference {
  Eigen::MatrixXd innovation, gain, covariance;
};

KalmanReference ReferenceUpdate(const Eigen::MatrixXd& prior, const Eigen::MatrixXd& h) {
  KalmanReference reference;
  const Eigen::MatrixXd state_by_rows = prior * h.transpose();
  reference.innovation = h * state_by_rows;
  reference.innovation.diagonal().array() += 1.0;
  const Eigen::MatrixXd inverse = reference.innovation.inverse();
  reference.gain = state_by_rows * inverse;
  // Joseph's form.
  Eigen::MatrixXd left = -reference.gain * h;
  left.diagonal().array() += 1.0;
  const Eigen::MatrixXd moved = left * prior;
  reference.covariance = moved * left.transpose();
  reference.covariance += reference.gain * reference.gain.transpose();
  return reference;
}

double MaxDifference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).cwiseAbs().maxCoeff();
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
  EXPECT_TRUE(now.topLeftCorner(removed, removed) == before.topLeftCorner(removed, removed));
  EXPECT_TRUE(now.bottomRightCorner(after, after) == before.bottomRightCorner(after, after));
  EXPECT_TRUE(now.topRightCorner(removed, after) == before.topRightCorner(removed, after));
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
  const KalmanReference reference = ReferenceUpdate(p, h);
  const Eigen::Vector3d velocity = state.imu().velocity_in_local;
  EXPECT_NEAR(state.SquaredMahalanobis(measurement),
              measurement.residual.dot(reference.innovation.lu().solve(measurement.residual)),
              1e-12);
  ASSERT_TRUE(state.Update(measurement));
  EXPECT_LT(MaxDifference(state.covariance(), reference.covariance), 1e-12);
  EXPECT_LT((state.imu().velocity_in_local - velocity -
             (reference.gain * measurement.residual).segment<3>(kVelocityIdx))
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
  // No eigenvalue is below -1e-12.
  Eigen::MatrixXd raised = state.covariance();
  raised.diagonal().array() += 1e-12;
  EXPECT_EQ(raised.llt().info(), Eigen::Success);
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
  const KalmanReference reference = ReferenceUpdate(prior, h);
  ASSERT_TRUE(state.InitializeGlobal(Rigid3d(), measurement));
  EXPECT_LT(MaxDifference(state.covariance(), reference.covariance), 1e-6);
  EXPECT_LT((state.global_from_local()->translation -
             (reference.gain * measurement.residual).segment<3>(kGlobalIdx))
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
  const KalmanReference reference = ReferenceUpdate(prior, h);
  // The covariance is that of the coordinates at the point of linearization, where no residual
  // moves them from.
  FilterState unmoved = state;
  PointRows without_residual = rows;
  without_residual.clones.residual.setZero();
  ASSERT_TRUE(unmoved.EnterPoint(2, 77, without_residual));
  EXPECT_LT(MaxDifference(InLocalCovariance(unmoved, 2), reference.covariance), 1e-4);
  ASSERT_TRUE(state.EnterPoint(2, 77, rows));
  EXPECT_EQ(Eigen::MatrixXd(state.covariance()), Eigen::MatrixXd(unmoved.covariance()));
  EXPECT_EQ(state.points()[2]->track_id, 77u);
  EXPECT_LT((unmoved.Locate(2).x_in_local - rows.x_in_local).norm(), 1e-12);
  const Eigen::Vector3d correction =
      unmoved.Locate(2).by_coordinates *
      (state.points()[2]->coordinates - unmoved.points()[2]->coordinates);
  EXPECT_LT((correction - (reference.gain * rows.clones.residual).segment<3>(point)).norm(), 1e-3);
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
  const Eigen::MatrixXd before = InLocalCovariance(state, 2);
  EXPECT_EQ(state.points()[2]->anchor, 2);
  state.RemoveClone(2);
  EXPECT_EQ(state.points()[2]->anchor, 1);
  EXPECT_LT((state.Locate(2).x_in_local - x_in_local).norm(), 1e-12);
  const Eigen::MatrixXd after = InLocalCovariance(state, 2);
  EXPECT_TRUE(after.isApprox(before.topLeftCorner(state.dim(), state.dim()), 1e-9));
  state.RemoveClone(0);  // The anchor is what it was, at another place.
  EXPECT_EQ(state.points()[2]->anchor, 0);
  EXPECT_LT((state.Locate(2).x_in_local - x_in_local).norm(), 1e-12);
  state.RemoveClone(0);
  EXPECT_FALSE(state.points()[2].has_value());
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

}  // namespace
}  // namespace cairn::fusion
