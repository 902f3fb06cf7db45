#include "fusion/map_updates/map_update.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/require.h"
#include "fusion/filter/chi_square.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {
namespace {

// Gate on all matches of a response that passed their own gates; passes 99.99 %. The gate is wide
// so that a linearization error of a fraction of a pixel in hundreds of matches does not reject a
// whole response.
constexpr double kResponseGateQuantile = 3.72;

// Each match of a response may fit alone while all of them together contradict the state by more
// than chance allows. The cause is an error that they share, such as an error of the exposure time.
// If the ratio of the squared distance to the gate is at most kMaxExcess, the response is still
// applied, with its noise enlarged until it passes the gate.
constexpr double kMaxExcess = 25.0;

// The columns that all observations share.
struct SharedColumns {
  std::vector<StateBlock> blocks;
  std::vector<uint64_t> tiles;  // In the order of their columns.
  int num_global_dims = 0;
  int rig_begin = 0;
  int tiles_begin = 0;
  int width = 0;
};

SharedColumns CollectShared(const std::vector<MapRows>& rows, int num_global_dims,
                            const FilterState& state) {
  SharedColumns shared;
  shared.num_global_dims = num_global_dims;
  shared.blocks.push_back({kGlobalIdx, num_global_dims});
  shared.rig_begin = num_global_dims;
  shared.tiles_begin = shared.rig_begin;
  if (state.estimates_rig()) {
    shared.blocks.push_back({kRigIdx, kRigDim});
    shared.tiles_begin += kRigDim;
  }
  shared.width = shared.tiles_begin;
  for (const MapRows& row : rows) {
    const auto tile_idx = state.FindTileIdx(row.tile_id);
    if (tile_idx &&
        std::find(shared.tiles.begin(), shared.tiles.end(), row.tile_id) == shared.tiles.end()) {
      shared.tiles.push_back(row.tile_id);
      shared.blocks.push_back({*tile_idx, kTileDim});
      shared.width += kTileDim;
    }
  }
  return shared;
}

// Observations at one clone observe global_from_local only together with the clone's pose. For
// every landmark, by_global = by_clone * (the returned matrix). With p the clone's first position:
// a shift rho acts as a shift of p; a turn of global_from_local about the axis e acts as a turn of
// the clone about e together with a shift by e x p.
Eigen::Matrix<double, kCloneDim, kGlobalDim> CloneByGlobal(const Clone& clone) {
  const Eigen::Matrix3d cross = Skew(clone.first_position_in_local);
  Eigen::Matrix<double, kCloneDim, kGlobalDim> matrix =
      Eigen::Matrix<double, kCloneDim, kGlobalDim>::Zero();
  matrix.bottomLeftCorner<3, 3>().setIdentity();
  constexpr int kAxes[] = {2, 0, 1};  // psi, then the tilts.
  for (int i = 0; i < 3; ++i) {
    matrix(kAxes[i], 3 + i) = 1.0;
    matrix.block<3, 1>(3, 3 + i) = -cross.col(kAxes[i]);
  }
  return matrix;
}

// CloneRows for the case in which global_from_local is the only shared block. Triangularizing the
// clone's columns is then enough.
Eigen::MatrixXd PlainCloneRows(const std::vector<const MapRows*>& rows, const Clone& clone,
                               int num_global_dims) {
  Eigen::Matrix<double, Eigen::Dynamic, kCloneDim + 1> stacked(
      2 * static_cast<Eigen::Index>(rows.size()), kCloneDim + 1);
  Eigen::Index row = 0;
  for (const MapRows* observation : rows) {
    stacked.middleRows<2>(row) << observation->by_clone, observation->residual;
    row += 2;
  }
  Triangularize(kCloneDim, stacked);
  const Eigen::Index num_rows = std::min<Eigen::Index>(stacked.rows(), kCloneDim);
  Eigen::MatrixXd triangle(num_rows, kCloneDim + num_global_dims + 1);
  triangle.leftCols<kCloneDim>() = stacked.topLeftCorner(num_rows, kCloneDim);
  triangle.middleCols(kCloneDim, num_global_dims) =
      triangle.leftCols<kCloneDim>() * CloneByGlobal(clone).leftCols(num_global_dims);
  triangle.rightCols<1>() = stacked.topRightCorner(num_rows, 1);
  return triangle;
}

// The triangularized rows of one clone: its own columns first, the residual last.
Eigen::MatrixXd CloneRows(const std::vector<const MapRows*>& rows, const SharedColumns& shared) {
  const int width = kCloneDim + shared.width + 1;
  Eigen::MatrixXd stacked =
      Eigen::MatrixXd::Zero(2 * static_cast<Eigen::Index>(rows.size()), width);
  Eigen::Index row = 0;
  for (const MapRows* observation : rows) {
    auto target = stacked.middleRows<2>(row);
    target.leftCols<kCloneDim>() = observation->by_clone;
    target.middleCols(kCloneDim, shared.num_global_dims) =
        observation->by_global.leftCols(shared.num_global_dims);
    if (shared.tiles_begin > shared.rig_begin) {
      target.middleCols<kRigDim>(kCloneDim + shared.rig_begin) = observation->by_rig;
    }
    const auto tile = std::find(shared.tiles.begin(), shared.tiles.end(), observation->tile_id);
    if (tile != shared.tiles.end()) {
      const auto slot = static_cast<int>(tile - shared.tiles.begin());
      target.middleCols<kTileDim>(kCloneDim + shared.tiles_begin + kTileDim * slot) =
          observation->by_tile;
    }
    target.col(width - 1) = observation->residual;
    row += 2;
  }
  Triangularize(width - 1, stacked);
  return stacked.topRows(std::min<Eigen::Index>(stacked.rows(), width - 1));
}

// Squared Mahalanobis distances of the observations at one clone.
class CloneGate {
 public:
  CloneGate(const FilterState& state, int clone)
      : tile_variance_(state.has_tiles() ? state.tile_sigma_m() * state.tile_sigma_m() : 0.0),
        estimates_rig_(state.estimates_rig()) {
    // The observations see the errors of the clone and of global_from_local as one error. of_pose_
    // is the covariance of that combined error.
    const auto covariance = state.covariance();
    const int idx = state.CloneIdx(clone);
    const Eigen::Matrix<double, kCloneDim, kGlobalDim> by_global =
        CloneByGlobal(state.clones()[static_cast<size_t>(clone)]);
    const Eigen::Matrix<double, kCloneDim, kCloneDim> cross =
        by_global * covariance.block<kGlobalDim, kCloneDim>(kGlobalIdx, idx);
    of_pose_ = covariance.block<kCloneDim, kCloneDim>(idx, idx) + cross + cross.transpose() +
               by_global * covariance.block<kGlobalDim, kGlobalDim>(kGlobalIdx, kGlobalIdx) *
                   by_global.transpose();
    if (estimates_rig_) {
      with_rig_ = covariance.block<kCloneDim, kRigDim>(idx, kRigIdx) +
                  by_global * covariance.block<kGlobalDim, kRigDim>(kGlobalIdx, kRigIdx);
      of_rig_ = covariance.block<kRigDim, kRigDim>(kRigIdx, kRigIdx);
    }
  }

  double SquaredDistance(const MapRows& rows) const {
    const Eigen::Matrix<double, 2, kCloneDim> moved = rows.by_clone * of_pose_;
    Eigen::Matrix2d innovation = moved * rows.by_clone.transpose();
    innovation.diagonal().array() += 1.0;
    if (estimates_rig_) {
      const Eigen::Matrix2d cross = rows.by_clone * with_rig_ * rows.by_rig.transpose();
      innovation += cross + cross.transpose() + rows.by_rig * of_rig_ * rows.by_rig.transpose();
    }
    innovation += tile_variance_ * rows.by_tile * rows.by_tile.transpose();
    return rows.residual.dot(innovation.inverse() * rows.residual);
  }

 private:
  Eigen::Matrix<double, kCloneDim, kCloneDim> of_pose_;
  Eigen::Matrix<double, kCloneDim, kRigDim> with_rig_;
  Eigen::Matrix<double, kRigDim, kRigDim> of_rig_;
  double tile_variance_;
  bool estimates_rig_;
};

void Weigh(double weight, Measurement* measurement) {
  measurement->jacobian *= weight;
  measurement->residual *= weight;
}

// Linearizes the used observations at `state`.
std::vector<MapRows> LinearizeUsed(const Camera& camera, const FilterState& state,
                                   std::span<const MapObservation> observations,
                                   const std::vector<bool>& used, const MapUpdateOptions& options) {
  const std::vector<CameraView> views = ViewsOfClones(state);
  std::vector<MapRows> rows;
  for (size_t i = 0; i < observations.size(); ++i) {
    const auto linearized =
        used[i] ? LinearizeObservation(camera, state.rig(), views, *state.global_from_local(),
                                       observations[i], options.sigma_px)
                : std::nullopt;
    if (linearized) {
      rows.push_back(*linearized);
    }
  }
  return rows;
}

// The gates of all clones. A clone's gate is made when its first row comes.
class CloneGates {
 public:
  CloneGates(const FilterState& state, double quantile)
      : state_(state), quantile_(quantile), gates_(state.clones().size()) {}

  bool Passes(const MapRows& row) {
    std::optional<CloneGate>& gate = gates_[static_cast<size_t>(row.clone)];
    if (!gate) {
      gate.emplace(state_, row.clone);
    }
    return gate->SquaredDistance(row) < quantile_;
  }

 private:
  const FilterState& state_;
  const double quantile_;
  std::vector<std::optional<CloneGate>> gates_;
};

// The observations that pass their gates. `result` has the counts and the used observations.
struct GatedObservations {
  MapUpdateResult result;
  std::vector<MapRows> rows;
  int num_seen = 0;  // Matches whose first observation was tried.
};

// The first observation of a match decides on the match; the others are tried only if it passes.
GatedObservations GateObservations(const Camera& camera,
                                   std::span<const MapObservation> observations,
                                   const MapUpdateOptions& options, const FilterState& state) {
  const std::vector<CameraView> views = ViewsOfClones(state);
  CloneGates gates(state, ChiSquareQuantile(2, kMatchGateQuantile));
  GatedObservations gated;
  gated.result.used_observations.assign(observations.size(), false);
  gated.rows.reserve(observations.size());
  bool match_accepted = false;
  for (size_t i = 0; i < observations.size(); ++i) {
    const bool queried = i == 0 || observations[i].match != observations[i - 1].match;
    if (!queried && !match_accepted) {
      continue;
    }
    const auto linearized = LinearizeObservation(
        camera, state.rig(), views, *state.global_from_local(), observations[i], options.sigma_px);
    const bool accepted = linearized && gates.Passes(*linearized);
    if (queried) {
      ++gated.num_seen;
      match_accepted = accepted;
      ++(accepted ? gated.result.num_matches : gated.result.num_gated);
    }
    if (accepted) {
      gated.rows.push_back(*linearized);
      gated.result.used_observations[i] = true;
    }
  }
  return gated;
}

}  // namespace

void MapUpdateOptions::Validate() const {
  RequireOption(sigma_px > 0.0, "map.sigma_px must be positive");
  RequireOption(tilt_sigma_rad >= 0.0, "map.tilt_sigma_rad must not be negative");
}

std::optional<MapRows> LinearizeObservation(const Camera& camera, const Rig& rig,
                                            std::span<const CameraView> views,
                                            const Rigid3d& global_from_local,
                                            const MapObservation& observation, double sigma_px) {
  const CameraView& view = views[static_cast<size_t>(observation.clone)];
  const Eigen::Matrix3d local_from_global =
      global_from_local.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d x_in_local =
      local_from_global * (observation.x_in_global - global_from_local.translation);
  const auto predicted = PredictPixel(camera, view, x_in_local);
  if (!predicted) {
    return std::nullopt;
  }
  // Noise of the pixel plus noise of the landmark: s^2 I + sigma^2 D D'.
  Eigen::Matrix2d noise = observation.sigma_m * observation.sigma_m * predicted->by_local *
                          predicted->by_local.transpose();
  noise.diagonal().array() += sigma_px * sigma_px;
  const Eigen::Matrix2d whitening =
      Eigen::LLT<Eigen::Matrix2d>(noise).matrixL().solve(Eigen::Matrix2d::Identity());
  MapRows rows;
  rows.clone = observation.clone;
  rows.tile_id = observation.tile_id;
  rows.by_clone = whitening * ByClone(*predicted, view, x_in_local);
  rows.by_global = whitening * ByGlobal(*predicted, x_in_local);
  rows.by_tile = whitening * predicted->by_local * local_from_global;
  rows.by_rig = whitening * ByRig(*predicted, rig);
  rows.residual = whitening * (observation.pixel - predicted->pixel);
  return rows;
}

void AddTiles(std::span<const MapObservation> observations, FilterState* state) {
  if (state->has_tiles()) {
    for (const MapObservation& observation : observations) {
      state->TileIdx(observation.tile_id);
    }
  }
}

Measurement CompressMapRows(const std::vector<MapRows>& rows, int num_global_dims,
                            const FilterState& state) {
  const SharedColumns shared = CollectShared(rows, num_global_dims, state);
  std::vector<std::vector<const MapRows*>> by_clone(state.clones().size());
  for (const MapRows& row : rows) {
    by_clone[static_cast<size_t>(row.clone)].push_back(&row);
  }
  Measurement measurement;
  measurement.blocks = shared.blocks;
  std::vector<Eigen::MatrixXd> triangles;
  Eigen::Index num_shared_rows = 0;
  Eigen::Index num_clone_rows = 0;
  for (size_t i = 0; i < by_clone.size(); ++i) {
    if (by_clone[i].empty()) {
      continue;
    }
    measurement.blocks.push_back({state.CloneIdx(static_cast<int>(i)), kCloneDim});
    triangles.push_back(shared.width == num_global_dims
                            ? PlainCloneRows(by_clone[i], state.clones()[i], num_global_dims)
                            : CloneRows(by_clone[i], shared));
    const Eigen::Index own = std::min<Eigen::Index>(kCloneDim, triangles.back().rows());
    num_clone_rows += own;
    num_shared_rows += triangles.back().rows() - own;
  }
  Eigen::MatrixXd rest(num_shared_rows, shared.width + 1);
  const Eigen::Index num_kept = std::min<Eigen::Index>(num_shared_rows, shared.width);
  measurement.jacobian =
      Eigen::MatrixXd::Zero(num_clone_rows + num_kept,
                            shared.width + kCloneDim * static_cast<Eigen::Index>(triangles.size()));
  measurement.residual.resize(num_clone_rows + num_kept);
  Eigen::Index row = 0;
  Eigen::Index rest_row = 0;
  Eigen::Index column = shared.width;
  for (const Eigen::MatrixXd& triangle : triangles) {
    const Eigen::Index own = std::min<Eigen::Index>(kCloneDim, triangle.rows());
    measurement.jacobian.block(row, column, own, kCloneDim) =
        triangle.topLeftCorner(own, kCloneDim);
    measurement.jacobian.block(row, 0, own, shared.width) =
        triangle.block(0, kCloneDim, own, shared.width);
    measurement.residual.segment(row, own) = triangle.col(triangle.cols() - 1).head(own);
    const Eigen::Index below = triangle.rows() - own;
    rest.middleRows(rest_row, below) = triangle.bottomRightCorner(below, shared.width + 1);
    row += own;
    rest_row += below;
    column += kCloneDim;
  }
  Triangularize(shared.width, rest);
  measurement.jacobian.block(row, 0, num_kept, shared.width) =
      rest.topLeftCorner(num_kept, shared.width);
  measurement.residual.tail(num_kept) = rest.col(shared.width).head(num_kept);
  return measurement;
}

MapUpdateResult UpdateFromMap(const Camera& camera, std::span<const MapObservation> observations,
                              const MapUpdateOptions& options, FilterState* state) {
  const int num_dims = options.num_global_dims();
  AddTiles(observations, state);
  const GatedObservations gated = GateObservations(camera, observations, options, *state);
  MapUpdateResult result = gated.result;
  const auto refuse = [&result](MapUpdateStatus status) {
    result.status = status;
    std::fill(result.used_observations.begin(), result.used_observations.end(), false);
    return result;
  };
  if (result.num_matches < kMinMapInlierFraction * gated.num_seen) {
    return refuse(MapUpdateStatus::kDisagrees);
  }
  if (result.num_matches < kMinMapMatches) {
    return refuse(MapUpdateStatus::kTooFewMatches);
  }
  Measurement measurement = CompressMapRows(gated.rows, num_dims, *state);
  const double excess = state->SquaredMahalanobis(measurement) /
                        ChiSquareQuantile(measurement.num_rows(), kResponseGateQuantile);
  if (!(excess < kMaxExcess)) {
    return refuse(MapUpdateStatus::kDisagrees);
  }
  const double weight = 1.0 / std::sqrt(std::max(1.0, excess));
  Weigh(weight, &measurement);
  bool linearized = true;  // `measurement` is linearized at the present state.
  const auto linearize = [&](const FilterState& at) {
    if (std::exchange(linearized, false)) {
      return measurement;
    }
    Measurement again = CompressMapRows(
        LinearizeUsed(camera, at, observations, result.used_observations, options), num_dims, at);
    Weigh(weight, &again);
    return again;
  };
  return state->IteratedUpdate(linearize) ? result : refuse(MapUpdateStatus::kDisagrees);
}

}  // namespace cairn::fusion
