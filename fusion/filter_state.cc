#include "fusion/filter_state.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/check.h"
#include "core/error.h"

namespace cairn::fusion {

void FilterStateOptions::Validate() const {
  for (const double sigma : {extrinsic_rotation_sigma_rad, extrinsic_translation_sigma_m,
                             time_offset_sigma_s, tile_sigma_m}) {
    if (!(sigma >= 0.0) || !std::isfinite(sigma)) {
      throw Error(ErrorCode::kInvalidArgument,
                  "standard deviations of rig and tiles must be finite and not negative");
    }
  }
}

FilterState::FilterState(const ImuState& imu, const Matrix15d& covariance, const Rig& rig,
                         const FilterStateOptions& options)
    : imu_(imu),
      first_{imu.local_from_imu.translation, imu.velocity_in_local},
      rig_(rig),
      estimates_rig_(options.extrinsic_rotation_sigma_rad > 0.0 ||
                     options.extrinsic_translation_sigma_m > 0.0 ||
                     options.time_offset_sigma_s > 0.0),
      tile_sigma_m_(options.tile_sigma_m),
      tiles_idx_(kRigIdx + (estimates_rig_ ? kRigDim : 0)),
      clones_idx_(tiles_idx_ + (options.tile_sigma_m > 0.0 ? kTileDim * kMaxTiles : 0)) {
  clones_.reserve(kMaxClones);
  covariance_.topLeftCorner<kImuDim, kImuDim>() = covariance;
  if (estimates_rig_) {
    auto diagonal = covariance_.diagonal().segment<kRigDim>(kRigIdx);
    diagonal.head<3>().setConstant(std::pow(options.extrinsic_rotation_sigma_rad, 2));
    diagonal.segment<3>(3).setConstant(std::pow(options.extrinsic_translation_sigma_m, 2));
    diagonal[6] = std::pow(options.time_offset_sigma_s, 2);
  }
}

void FilterState::Propagate(const ImuState& end, const FirstEstimate& first,
                            const ImuTransition& transition) {
  const int rest = dim() - kImuDim;
  const Matrix15d moved = transition.phi * covariance_.topLeftCorner<kImuDim, kImuDim>();
  Matrix15d imu_covariance = moved * transition.phi.transpose() + transition.noise;
  covariance_.topLeftCorner<kImuDim, kImuDim>() =
      0.5 * (imu_covariance + imu_covariance.transpose());
  const Eigen::Matrix<double, kImuDim, Eigen::Dynamic, 0, kImuDim, kMaxStateDim> cross =
      transition.phi * covariance_.block(0, kImuDim, kImuDim, rest);
  covariance_.block(0, kImuDim, kImuDim, rest) = cross;
  covariance_.block(kImuDim, 0, rest, kImuDim) = cross.transpose();
  imu_ = end;
  first_ = first;
}

void FilterState::AddClone(int64_t frame_id, int64_t timestamp_ns,
                           const Eigen::Vector3d& imu_rate_rad_s) {
  CAIRN_CHECK(clones_.size() < kMaxClones, "room for one more clone");
  const int old_dim = dim();
  // The clone's error is the pose's, plus how far the pose moves in an error of the time offset.
  covariance_.block(old_dim, 0, kCloneDim, old_dim) = covariance_.block(0, 0, kCloneDim, old_dim);
  if (estimates_rig_) {
    Eigen::Matrix<double, kCloneDim, 1> by_time;
    by_time << imu_.local_from_imu.rotation * imu_rate_rad_s, imu_.velocity_in_local;
    covariance_.block(old_dim, 0, kCloneDim, old_dim) +=
        by_time * covariance_.row(kRigIdx + 6).head(old_dim);
    covariance_.block(0, old_dim, old_dim, kCloneDim) =
        covariance_.block(old_dim, 0, kCloneDim, old_dim).transpose();
    covariance_.block<kCloneDim, kCloneDim>(old_dim, old_dim) =
        covariance_.block<kCloneDim, kCloneDim>(old_dim, 0) +
        covariance_.block<kCloneDim, 1>(old_dim, kRigIdx + 6) * by_time.transpose();
  } else {
    covariance_.block(0, old_dim, old_dim, kCloneDim) =
        covariance_.block(old_dim, 0, kCloneDim, old_dim).transpose();
    covariance_.block<kCloneDim, kCloneDim>(old_dim, old_dim) =
        covariance_.block<kCloneDim, kCloneDim>(0, 0);
  }
  clones_.push_back({frame_id, timestamp_ns, imu_.local_from_imu, first_.position_in_local});
}

void FilterState::RemoveClone(int clone) {
  const int begin = CloneIdx(clone);
  const int old_dim = dim();
  const int after = old_dim - begin - kCloneDim;
  // Rows and columns behind the clone move up, one at a time so that nothing is overwritten early.
  for (int i = 0; i < after; ++i) {
    covariance_.col(begin + i).head(old_dim) = covariance_.col(begin + kCloneDim + i).head(old_dim);
  }
  for (int i = 0; i < after; ++i) {
    covariance_.row(begin + i).head(old_dim) = covariance_.row(begin + kCloneDim + i).head(old_dim);
  }
  covariance_.block(old_dim - kCloneDim, 0, kCloneDim, old_dim).setZero();
  covariance_.block(0, old_dim - kCloneDim, old_dim, kCloneDim).setZero();
  clones_.erase(clones_.begin() + clone);
}

int FilterState::TileIdx(uint64_t tile_id) {
  CAIRN_CHECK(has_tiles(), "tiles are part of the state");
  size_t slot = 0;
  for (size_t i = 0; i < tiles_.size(); ++i) {
    if (tiles_[i].tile_id == tile_id) {
      slot = i;
      break;
    }
    if (tiles_[i].last_use < tiles_[slot].last_use) {
      slot = i;
    }
  }
  const int offset = tiles_idx_ + kTileDim * static_cast<int>(slot);
  if (tiles_[slot].tile_id != tile_id) {
    tiles_[slot].tile_id = tile_id;
    covariance_.middleRows<kTileDim>(offset).setZero();
    covariance_.middleCols<kTileDim>(offset).setZero();
    covariance_.diagonal().segment<kTileDim>(offset).setConstant(tile_sigma_m_ * tile_sigma_m_);
  }
  tiles_[slot].last_use = ++tile_clock_;
  return offset;
}

std::optional<int> FilterState::FindTileIdx(uint64_t tile_id) const {
  for (size_t i = 0; i < tiles_.size(); ++i) {
    if (tiles_[i].tile_id == tile_id) {
      return tiles_idx_ + kTileDim * static_cast<int>(i);
    }
  }
  return std::nullopt;
}

Eigen::MatrixXd FilterState::CovarianceColumns(const std::vector<StateBlock>& blocks) const {
  Eigen::Index width = 0;
  for (const StateBlock& block : blocks) {
    width += block.size;
  }
  Eigen::MatrixXd columns(dim(), width);
  Eigen::Index next = 0;
  for (const StateBlock& block : blocks) {
    columns.middleCols(next, block.size) = covariance_.block(0, block.offset, dim(), block.size);
    next += block.size;
  }
  return columns;
}

Eigen::MatrixXd FilterState::InnovationCovariance(const Measurement& measurement,
                                                  const Eigen::MatrixXd& state_by_rows) const {
  Eigen::MatrixXd innovation =
      Eigen::MatrixXd::Identity(measurement.num_rows(), measurement.num_rows());
  Eigen::Index next = 0;
  for (const StateBlock& block : measurement.blocks) {
    innovation.noalias() += measurement.jacobian.middleCols(next, block.size) *
                            state_by_rows.middleRows(block.offset, block.size);
    next += block.size;
  }
  return innovation;
}

double FilterState::SquaredMahalanobis(const Measurement& measurement) const {
  Eigen::MatrixXd block_covariance(measurement.jacobian.cols(), measurement.jacobian.cols());
  Eigen::Index column = 0;
  for (const StateBlock& right : measurement.blocks) {
    Eigen::Index row = 0;
    for (const StateBlock& left : measurement.blocks) {
      block_covariance.block(row, column, left.size, right.size) =
          covariance_.block(left.offset, right.offset, left.size, right.size);
      row += left.size;
    }
    column += right.size;
  }
  Eigen::MatrixXd innovation =
      measurement.jacobian * block_covariance * measurement.jacobian.transpose();
  innovation.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> llt(innovation);
  return llt.info() == Eigen::Success ? llt.matrixL().solve(measurement.residual).squaredNorm()
                                      : std::numeric_limits<double>::infinity();
}

bool FilterState::Update(const Measurement& measurement) {
  if (measurement.num_rows() == 0) {
    return true;
  }
  Eigen::MatrixXd state_by_rows =
      CovarianceColumns(measurement.blocks) * measurement.jacobian.transpose();
  const Eigen::LLT<Eigen::MatrixXd> llt(InnovationCovariance(measurement, state_by_rows));
  const Eigen::VectorXd whitened = llt.matrixL().solve(measurement.residual);
  if (llt.info() != Eigen::Success || !whitened.allFinite()) {
    return false;
  }
  // With S = L L' and W = L^-1 H P: the correction is W' L^-1 r, the covariance loses W' W.
  Eigen::MatrixXd gain = state_by_rows.transpose();
  llt.matrixL().solveInPlace(gain);
  const Eigen::VectorXd error = gain.transpose() * whitened;
  const int num_tiles_dims = clones_idx_ - tiles_idx_;
  const Eigen::MatrixXd tiles =
      covariance_.block(tiles_idx_, tiles_idx_, num_tiles_dims, num_tiles_dims);
  auto lower = covariance_.topLeftCorner(dim(), dim()).selfadjointView<Eigen::Lower>();
  lower.rankUpdate(gain.transpose(), -1.0);
  covariance_.topLeftCorner(dim(), dim()).triangularView<Eigen::StrictlyUpper>() =
      covariance_.topLeftCorner(dim(), dim()).transpose();
  covariance_.block(tiles_idx_, tiles_idx_, num_tiles_dims, num_tiles_dims) = tiles;
  Correct(error);
  return true;
}

void FilterState::Correct(const Eigen::VectorXd& error) {
  const auto turn = [&error](int offset, Eigen::Quaterniond* rotation) {
    *rotation = (ExpSo3(error.segment<3>(offset)) * *rotation).normalized();
  };
  turn(kThetaIdx, &imu_.local_from_imu.rotation);
  imu_.local_from_imu.translation += error.segment<3>(kPositionIdx);
  imu_.velocity_in_local += error.segment<3>(kVelocityIdx);
  imu_.gyro_bias += error.segment<3>(kGyroBiasIdx);
  imu_.accel_bias += error.segment<3>(kAccelBiasIdx);
  if (global_from_local_) {
    const Eigen::Vector3d rotation(error[kGlobalIdx + 4], error[kGlobalIdx + 5],
                                   error[kGlobalIdx + 3]);
    *global_from_local_ =
        *global_from_local_ * Rigid3d(ExpSo3(rotation), error.segment<3>(kGlobalIdx));
  }
  if (estimates_rig_) {
    turn(kRigIdx, &rig_.cam_from_imu.rotation);
    rig_.cam_from_imu.translation += error.segment<3>(kRigIdx + 3);
    rig_.time_offset_s += error[kRigIdx + 6];
  }
  for (size_t i = 0; i < clones_.size(); ++i) {
    const int offset = CloneIdx(static_cast<int>(i));
    turn(offset, &clones_[i].local_from_imu.rotation);
    clones_[i].local_from_imu.translation += error.segment<3>(offset + 3);
  }
}

Eigen::VectorXd FilterState::ErrorFrom(const FilterState& from) const {
  Eigen::VectorXd error = Eigen::VectorXd::Zero(dim());
  const auto pose = [&error](int offset, const Rigid3d& to, const Rigid3d& start) {
    error.segment<3>(offset) = LogSo3(to.rotation * start.rotation.conjugate());
    error.segment<3>(offset + 3) = to.translation - start.translation;
  };
  pose(kThetaIdx, imu_.local_from_imu, from.imu_.local_from_imu);
  error.segment<3>(kVelocityIdx) = imu_.velocity_in_local - from.imu_.velocity_in_local;
  error.segment<3>(kGyroBiasIdx) = imu_.gyro_bias - from.imu_.gyro_bias;
  error.segment<3>(kAccelBiasIdx) = imu_.accel_bias - from.imu_.accel_bias;
  if (global_from_local_ && from.global_from_local_) {
    const Rigid3d moved = from.global_from_local_->Inverse() * *global_from_local_;
    const Eigen::Vector3d rotation = LogSo3(moved.rotation);
    error.segment<3>(kGlobalIdx) = moved.translation;
    error.segment<3>(kGlobalIdx + 3) << rotation.z(), rotation.x(), rotation.y();
  }
  if (estimates_rig_) {
    pose(kRigIdx, rig_.cam_from_imu, from.rig_.cam_from_imu);
    error[kRigIdx + 6] = rig_.time_offset_s - from.rig_.time_offset_s;
  }
  for (size_t i = 0; i < clones_.size(); ++i) {
    pose(CloneIdx(static_cast<int>(i)), clones_[i].local_from_imu, from.clones_[i].local_from_imu);
  }
  return error;
}

double LinearizationDoubt(const FilterState& state, const Eigen::VectorXd& error) {
  constexpr double kMaxTurnRad = 3e-3;
  constexpr double kMaxShiftM = 0.02;
  double doubt = 0.0;
  for (int i = 0; i < static_cast<int>(state.clones().size()); ++i) {
    const int offset = state.CloneIdx(i);
    doubt = std::max({doubt, error.segment<3>(offset).norm() / kMaxTurnRad,
                      error.segment<3>(offset + 3).norm() / kMaxShiftM});
  }
  return doubt;
}

bool FilterState::InitializeGlobal(const Rigid3d& global_from_local,
                                   const Measurement& measurement) {
  const int num_dims = measurement.blocks.front().size;
  const Eigen::Index num_rows = measurement.num_rows();
  const Eigen::Index num_rest_columns = measurement.jacobian.cols() - num_dims;
  if (num_rows < num_dims) {
    return false;
  }
  Eigen::MatrixXd rows(num_rows, measurement.jacobian.cols() + 1);
  rows << measurement.jacobian, measurement.residual;
  Triangularize(num_dims, rows);
  const Eigen::MatrixXd by_global = rows.topLeftCorner(num_dims, num_dims);
  // Standard deviations of 1 km or 60 degrees are no alignment.
  if (!(by_global.diagonal().cwiseAbs().minCoeff() > 1e-3)) {
    return false;
  }
  // The top rows read r = T g + H x + n: g = T^-1 (r - H x - n), as an error about the given value.
  Measurement top{{measurement.blocks.begin() + 1, measurement.blocks.end()},
                  rows.block(0, num_dims, num_dims, num_rest_columns),
                  rows.col(rows.cols() - 1).head(num_dims)};
  Measurement rest{top.blocks,
                   rows.block(num_dims, num_dims, num_rows - num_dims, num_rest_columns),
                   rows.col(rows.cols() - 1).tail(num_rows - num_dims)};
  const auto triangle = by_global.triangularView<Eigen::Upper>();
  const Eigen::MatrixXd state_by_rows = CovarianceColumns(top.blocks) * top.jacobian.transpose();
  const Eigen::MatrixXd inverse = triangle.solve(Eigen::MatrixXd::Identity(num_dims, num_dims));
  global_from_local_ = global_from_local;
  SetGlobalRows(-inverse * state_by_rows.transpose(),
                inverse * InnovationCovariance(top, state_by_rows) * inverse.transpose());
  Eigen::VectorXd error = Eigen::VectorXd::Zero(dim());
  error.segment(kGlobalIdx, num_dims) = inverse * top.residual;
  Correct(error);
  Compress(&rest);
  if (!Update(rest)) {
    ForgetGlobal();
    return false;
  }
  return true;
}

void FilterState::SetGlobalRows(const Eigen::MatrixXd& global_by_state,
                                const Eigen::MatrixXd& global_block) {
  const Eigen::Index num_dims = global_block.rows();
  covariance_.block(kGlobalIdx, 0, num_dims, dim()) = global_by_state;
  covariance_.block(0, kGlobalIdx, dim(), num_dims) = global_by_state.transpose();
  covariance_.block(kGlobalIdx, kGlobalIdx, num_dims, num_dims) =
      0.5 * (global_block + global_block.transpose());
}

void FilterState::ForgetGlobal() {
  global_from_local_.reset();
  covariance_.middleRows<kGlobalDim>(kGlobalIdx).setZero();
  covariance_.middleCols<kGlobalDim>(kGlobalIdx).setZero();
}

}  // namespace cairn::fusion
