#include "fusion/map_updates/map_update.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "fusion/filter/camera_view.h"
#include "fusion/moving_state.h"
#include "fusion/tracks/track_update.h"
#include "support/cameras.h"

namespace cairn::fusion {
namespace {

using testing::SomeState;

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
  std::vector<MapObservation> observations;
  for (int i = 0; i < 60; ++i) {
    const auto& view = views[static_cast<size_t>(i % 4)];
    const double depth_m = 6.0 + 3.0 * uniform(random);
    const Eigen::Vector3d x =
        view.center_in_local +
        view.cam_from_local_rotation.transpose() *
            Eigen::Vector3d(0.4 * uniform(random), 0.3 * uniform(random), 1.0) * depth_m;
    observations.push_back({i,
                            i % 4,
                            {300.0 + 20.0 * uniform(random), 200.0},
                            global_from_local * x,
                            0.02,
                            static_cast<uint64_t>(i % 2)});
  }
  AddTiles(observations, &state);
  std::vector<MapRows> rows;
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(120, state.dim());
  Eigen::VectorXd r(120);
  for (size_t i = 0; i < observations.size(); ++i) {
    rows.push_back(
        *LinearizeObservation(camera, state.rig(), views, global_from_local, observations[i], 1.0));
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
