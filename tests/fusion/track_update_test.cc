#include "fusion/tracks/track_update.h"

#include <gtest/gtest.h>

#include <vector>

namespace cairn::fusion {
namespace {

constexpr int kNumTrackClones = 5;
constexpr double kErrorSize = 1e-5;

// Five clones on a curve of half a meter, aligned, and a truth that is off by a small error.
class TrackWithMapDistance : public ::testing::TestWithParam<bool> {
 protected:
  TrackWithMapDistance()
      : camera_(CameraModel::kPinhole, 640, 480, {500, 510, 325, 236}), state_(MakeState()) {
    error_ = kErrorSize * Eigen::VectorXd::NullaryExpr(state_.dim(), [](Eigen::Index i) {
               return std::sin(1.0 + 3.7 * static_cast<double>(i * i));
             });
    Observe();
  }

  static FilterState MakeState() {
    FilterStateOptions options;
    options.tile_sigma_m = GetParam() ? 0.1 : 0.0;
    ImuState imu;
    imu.local_from_imu = Rigid3d(ExpSo3({0.1, -0.2, 0.5}), Eigen::Vector3d(1.0, 2.0, 3.0));
    imu.velocity_in_local = {0.5, 1.0, -0.2};
    const Rig rig{Rigid3d(ExpSo3({1.2, -1.1, 1.3}), Eigen::Vector3d(0.03, 0.01, -0.05)), 0.0};
    FilterState state(imu, 1e-3 * Matrix15d::Identity(), rig, options);
    FirstEstimate first = state.first();
    for (int i = 0; i < kNumTrackClones; ++i) {
      ImuState end = state.imu();
      ImuTransition transition;
      for (int k = 0; k < 20; ++k) {
        Propagate({{0.1, 0.2, 0.1}, {0.5, 0.3, 9.8}, 0.005}, ImuNoise(), 9.81, &end, &first,
                  &transition);
      }
      state.Propagate(end, first, transition);
      state.AddClone(i + 1, i, {0.1, 0.2, 0.1});
    }
    const Rigid3d global_from_local(ExpSo3({0.0, 0.0, 0.8}), Eigen::Vector3d(30.0, -20.0, 5.0));
    state.InitializeGlobal(
        global_from_local,
        {{{kGlobalIdx, 4}}, 10.0 * Eigen::Matrix4d::Identity(), Eigen::Vector4d::Zero()});
    return state;
  }

  // What the clones would see, and the map say, if the state were off by the error.
  void Observe() {
    const CameraView last(state_.rig(), state_.clones().back());
    const Eigen::Vector3d x_in_local =
        last.center_in_local +
        last.cam_from_local_rotation.transpose() * Eigen::Vector3d(0.5, -0.3, 4.0);
    for (int i = 0; i < kNumTrackClones; ++i) {
      Clone clone = state_.clones()[static_cast<size_t>(i)];
      const auto error = error_.segment<kCloneDim>(state_.CloneIdx(i));
      clone.local_from_imu.rotation = ExpSo3(error.head<3>()) * clone.local_from_imu.rotation;
      clone.local_from_imu.translation += error.tail<3>();
      const auto seen = PredictPixel(camera_, CameraView(state_.rig(), clone), x_in_local);
      ASSERT_TRUE(seen.has_value());
      observations_.push_back({clone.frame_id, seen->pixel, seen->x_in_cam.normalized(), false});
    }
    const auto error = error_.segment<kGlobalDim>(kGlobalIdx);
    const Rigid3d global_from_local =
        *state_.global_from_local() *
        Rigid3d(ExpSo3({error[4], error[5], error[3]}), error.head<3>());
    distance_ = {global_from_local * x_in_local, Eigen::Vector3d(0.6, 0.0, 0.8), 0.05, 9};
    if (state_.has_tiles()) {
      distance_.x_in_global -= error_.segment<kTileDim>(state_.TileIdx(9));
    }
  }

  // By the whole state.
  Eigen::MatrixXd Jacobian(const Measurement& measurement) const {
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(measurement.num_rows(), state_.dim());
    Eigen::Index column = 0;
    for (const StateBlock& block : measurement.blocks) {
      jacobian.middleCols(block.offset, block.size) =
          measurement.jacobian.middleCols(column, block.size);
      column += block.size;
    }
    return jacobian;
  }

  std::optional<TrackRows> Linearize(const std::optional<MapDistance>& distance) const {
    return LinearizeTrack(state_, camera_, ViewsOfClones(state_), observations_, {}, distance);
  }

  Camera camera_;
  FilterState state_;
  Eigen::VectorXd error_;
  std::vector<Observation> observations_;
  MapDistance distance_;
};

TEST_P(TrackWithMapDistance, RowsAreThoseOfTheError) {
  const auto rows = Linearize(distance_);
  ASSERT_TRUE(rows.has_value());
  ASSERT_EQ(rows->clones.num_rows(), 2 * kNumTrackClones - 2);
  const Eigen::VectorXd expected = Jacobian(rows->clones) * error_;
  EXPECT_GT(expected.norm(), 10.0 * kErrorSize);
  EXPECT_LT((rows->clones.residual - expected).norm(), 1e-2 * expected.norm());
  // Stacking keeps the information.
  const Measurement stacked = StackTracks(state_, {{*rows}});
  const Eigen::MatrixXd alone = Jacobian(rows->clones);
  const Eigen::MatrixXd all = Jacobian(stacked);
  EXPECT_TRUE((all.transpose() * all).isApprox(alone.transpose() * alone, 1e-9));
}

TEST_P(TrackWithMapDistance, RowsKnowNothingOfUnobservableDirections) {
  const auto rows = Linearize(distance_);
  ASSERT_TRUE(rows.has_value());
  // A shift of local, and a turn about its vertical.
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(state_.dim(), 4);
  directions.block<3, 3>(kGlobalIdx, 0) = -Eigen::Matrix3d::Identity();
  directions(kGlobalIdx + 3, 3) = -1.0;
  for (int i = 0; i < kNumTrackClones; ++i) {
    const Clone& clone = state_.clones()[static_cast<size_t>(i)];
    directions.block<3, 3>(state_.CloneIdx(i) + 3, 0).setIdentity();
    directions.block<3, 1>(state_.CloneIdx(i), 3) = Eigen::Vector3d::UnitZ();
    directions.block<3, 1>(state_.CloneIdx(i) + 3, 3) =
        Eigen::Vector3d::UnitZ().cross(clone.first_position_in_local);
  }
  EXPECT_LT((Jacobian(rows->clones) * directions).norm(), 1e-6);
}

TEST_P(TrackWithMapDistance, IsNotUsedBeforeTheAlignment) {
  state_.ForgetGlobal();
  const auto rows = Linearize(distance_);
  ASSERT_TRUE(rows.has_value());
  EXPECT_EQ(rows->clones.num_rows(), 2 * kNumTrackClones - 3);
}

TEST_P(TrackWithMapDistance, IsNotUsedWithoutItsTile) {
  distance_.tile_id = 10;
  const auto rows = Linearize(distance_);
  ASSERT_TRUE(rows.has_value());
  EXPECT_EQ(rows->clones.num_rows(), 2 * kNumTrackClones - (state_.has_tiles() ? 3 : 2));
}

INSTANTIATE_TEST_SUITE_P(Tiles, TrackWithMapDistance, ::testing::Bool());

}  // namespace
}  // namespace cairn::fusion
