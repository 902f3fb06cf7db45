#include "fusion/moving_state.h"

#include <random>

#include "core/inertial/imu_propagation.h"

namespace cairn::fusion::testing {
namespace {

Rig SomeRig() {
  return {Rigid3d(ExpSo3({1.2, -1.1, 1.3}), Eigen::Vector3d(0.03, 0.01, -0.05)), 0.0};
}

Rig LookingAhead() {
  Eigen::Matrix3d cam_from_imu;
  cam_from_imu << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {Rigid3d(cam_from_imu, Eigen::Vector3d::Zero()), 0.0};
}

// Moves the state by 0.1 s of constant readings.
void MoveOn(const ImuStep& step, FirstEstimate* first, FilterState* state) {
  ImuState end = state->imu();
  ImuTransition transition;
  for (int k = 0; k < 20; ++k) {
    Propagate(step, ImuNoise(), 9.81, &end, first, &transition);
  }
  state->Propagate(end, *first, transition);
}

}  // namespace

FilterState SomeState(int num_clones, const FilterStateOptions& options) {
  ImuState imu;
  imu.local_from_imu = Rigid3d(ExpSo3({0.1, -0.2, 0.5}), Eigen::Vector3d(1.0, 2.0, 3.0));
  imu.velocity_in_local = {0.5, 1.0, -0.2};
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, 0.05);
  const Matrix15d root = Matrix15d::NullaryExpr([&] { return normal(random); });
  FilterState state(imu, root * root.transpose(), SomeRig(), options);
  FirstEstimate first = state.first();
  for (int i = 0; i < num_clones; ++i) {
    MoveOn({{0.3, 0.2, 0.5}, {0.5, 0.3, 9.8}, 0.005}, &first, &state);
    state.AddClone(i + 1, i, {0.3, 0.2, 0.5});
  }
  return state;
}

FilterState MovingState(int num_clones, double speed_m_s, double sigma) {
  ImuState imu;
  imu.velocity_in_local = {0.0, speed_m_s, 0.0};
  FilterState state(imu, sigma * sigma * Matrix15d::Identity(), LookingAhead(), {});
  FirstEstimate first = state.first();
  for (int i = 0; i < num_clones; ++i) {
    if (i > 0) {
      MoveOn({Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}, 0.005}, &first, &state);
    }
    state.AddClone(i + 1, i * kCloneStepNs, Eigen::Vector3d::Zero());
  }
  return state;
}

void AlignAt(const Rigid3d& global_from_local, FilterState* state) {
  state->InitializeGlobal(
      global_from_local, {{{kGlobalIdx, 4}}, Eigen::Matrix4d::Identity(), Eigen::Vector4d::Zero()});
}

}  // namespace cairn::fusion::testing
