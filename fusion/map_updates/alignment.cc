#include "fusion/map_updates/alignment.h"

#include <Eigen/Cholesky>

#include "core/rotation_between.h"
#include "fusion/filter/chi_square.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {
namespace {

using GlobalVector = Eigen::Matrix<double, kGlobalDim, 1>;

// Moves global_from_local by an error whose entries are in the order of the state's global block.
Rigid3d Moved(const Rigid3d& global_from_local, const GlobalVector& error) {
  return global_from_local * Rigid3d(ExpSo3({error[4], error[5], error[3]}), error.head<3>());
}

// A linearized observation and the variance of its residual per axis: the unit noise plus the
// variance that the errors of the clone and the tile add.
struct WeighedRows {
  MapRows rows;
  double variance = 1.0;

  double SquaredResidual() const { return rows.residual.squaredNorm() / variance; }
};

// Returns the error that one Gauss-Newton step of the robust least squares finds.
GlobalVector RobustStep(const std::vector<WeighedRows>& observations, double cauchy_scale,
                        int num_dims) {
  Eigen::Matrix<double, kGlobalDim, kGlobalDim> normal =
      Eigen::Matrix<double, kGlobalDim, kGlobalDim>::Zero();
  GlobalVector gradient = GlobalVector::Zero();
  for (const WeighedRows& observation : observations) {
    const MapRows& row = observation.rows;
    const double weight = 1.0 / observation.variance /
                          (1.0 + observation.SquaredResidual() / (cauchy_scale * cauchy_scale));
    normal.noalias() += weight * row.by_global.transpose() * row.by_global;
    gradient.noalias() += weight * row.by_global.transpose() * row.residual;
  }
  GlobalVector error = GlobalVector::Zero();
  error.head(num_dims) =
      normal.topLeftCorner(num_dims, num_dims).ldlt().solve(gradient.head(num_dims));
  return error;
}

std::vector<WeighedRows> LinearizeAll(const Camera& camera, const FilterState& state,
                                      std::span<const CameraView> views,
                                      std::span<const MapObservation> observations,
                                      const Rigid3d& global_from_local, double sigma_px) {
  std::vector<WeighedRows> weighed;
  for (const MapObservation& observation : observations) {
    const auto rows =
        LinearizeObservation(camera, state.rig(), views, global_from_local, observation, sigma_px);
    if (!rows) {
      continue;
    }
    const int clone = state.CloneIdx(observation.clone);
    const Eigen::Matrix2d by_clone = rows->by_clone *
                                     state.covariance().block<kCloneDim, kCloneDim>(clone, clone) *
                                     rows->by_clone.transpose();
    const double by_tile =
        state.tile_sigma_m() * state.tile_sigma_m() * rows->by_tile.squaredNorm();
    weighed.push_back({*rows, 1.0 + 0.5 * (by_clone.trace() + by_tile)});
  }
  return weighed;
}

// Appends two rows: the tilt is zero with standard deviation `sigma_rad`.
void AppendTiltPrior(double sigma_rad, Measurement* measurement) {
  const Eigen::Index num_rows = measurement->num_rows();
  measurement->jacobian.conservativeResize(num_rows + 2, Eigen::NoChange);
  measurement->jacobian.bottomRows<2>().setZero();
  measurement->jacobian.block<2, 2>(num_rows, 4).setIdentity();
  measurement->jacobian.bottomRows<2>() /= sigma_rad;
  measurement->residual.conservativeResize(num_rows + 2);
  measurement->residual.tail<2>().setZero();
}

}  // namespace

LevelTransform Level(const Rigid3d& global_from_local, const Eigen::Vector3d& x_in_local) {
  const Eigen::Quaterniond yaw(
      Eigen::AngleAxisd(YawRad(global_from_local.rotation), Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d x_in_global = global_from_local * x_in_local;
  return {Rigid3d(yaw, x_in_global - yaw * x_in_local),
          RotationAngleRad(global_from_local.rotation, yaw)};
}

bool Agree(const Rigid3d& a, const Rigid3d& b, const Eigen::Vector3d& x_in_local) {
  constexpr double kMaxPositionDifferenceM = 1.0;
  constexpr double kMaxYawDifferenceRad = 0.07;  // 4 degrees.
  return (a * x_in_local - b * x_in_local).norm() < kMaxPositionDifferenceM &&
         RotationAngleRad(a.rotation, b.rotation) < kMaxYawDifferenceRad;
}

std::vector<int> LargestAgreeingSet(std::span<const Rigid3d> candidates,
                                    const Eigen::Vector3d& x_in_local) {
  std::vector<int> best;
  for (const Rigid3d& center : candidates) {
    std::vector<int> agreeing;
    for (size_t i = 0; i < candidates.size(); ++i) {
      if (Agree(center, candidates[i], x_in_local)) {
        agreeing.push_back(static_cast<int>(i));
      }
    }
    if (agreeing.size() > best.size()) {
      best = std::move(agreeing);
    }
  }
  return best;
}

bool Align(const Camera& camera, std::span<const MapObservation> observations,
           const Rigid3d& initial, const MapUpdateOptions& map, FilterState* state) {
  constexpr int kMaxIterations = 15;
  AddTiles(observations, state);
  const int num_dims = map.num_global_dims();
  const std::vector<CameraView> views = ViewsOfClones(*state);
  Rigid3d global_from_local = initial;
  // The answer's own pose may be off by tens of pixels, so the loss starts wide.
  double cauchy_scale = 30.0;
  for (int i = 0; i < kMaxIterations; ++i) {
    // These steps change yaw and translation only. The tilt needs its prior, which the final update
    // adds.
    const GlobalVector error = RobustStep(
        LinearizeAll(camera, *state, views, observations, global_from_local, map.sigma_px),
        cauchy_scale, 4);
    if (!error.allFinite()) {
      return false;
    }
    global_from_local = Moved(global_from_local, error);
    cauchy_scale = std::max(2.4, 0.5 * cauchy_scale);
  }
  const std::vector<WeighedRows> all =
      LinearizeAll(camera, *state, views, observations, global_from_local, map.sigma_px);
  // All observations of an answer share part of the clones' errors, so the gate is doubled.
  const double gate = 2.0 * ChiSquareQuantile(2, kMatchGateQuantile);
  std::vector<MapRows> inliers;
  for (const WeighedRows& observation : all) {
    if (observation.SquaredResidual() < gate) {
      inliers.push_back(observation.rows);
    }
  }
  if (inliers.size() < static_cast<size_t>(kMinMapMatches) ||
      static_cast<double>(inliers.size()) <
          kMinMapInlierFraction * static_cast<double>(all.size())) {
    return false;
  }
  Measurement measurement = CompressMapRows(inliers, num_dims, *state);
  if (num_dims == kGlobalDim) {
    AppendTiltPrior(map.tilt_sigma_rad, &measurement);
  }
  return state->InitializeGlobal(global_from_local, measurement);
}

}  // namespace cairn::fusion
