#include "fusion/filter/filter_state.h"

#include <Eigen/LU>
#include <cmath>

#include "core/check.h"
#include "core/require.h"

namespace cairn::fusion {

void FilterStateOptions::Validate() const {
  RequireOption(extrinsic_rotation_sigma_rad >= 0.0 && std::isfinite(extrinsic_rotation_sigma_rad),
                "state.extrinsic_rotation_sigma_rad must be finite and not negative");
  RequireOption(
      extrinsic_translation_sigma_m >= 0.0 && std::isfinite(extrinsic_translation_sigma_m),
      "state.extrinsic_translation_sigma_m must be finite and not negative");
  RequireOption(time_offset_sigma_s >= 0.0 && std::isfinite(time_offset_sigma_s),
                "state.time_offset_sigma_s must be finite and not negative");
  RequireOption(tile_sigma_m >= 0.0 && std::isfinite(tile_sigma_m),
                "state.tile_sigma_m must be finite and not negative");
  RequireWithin("state.max_points", max_points, 0, kMaxPoints);
}

FilterState::FilterState(const ImuState& imu, const Matrix15d& covariance, const Rig& rig,
                         const FilterStateOptions& options)
    : mean_{imu, rig, std::nullopt, {}, {}},
      first_{imu.local_from_imu.translation, imu.velocity_in_local},
      estimates_rig_(options.extrinsic_rotation_sigma_rad > 0.0 ||
                     options.extrinsic_translation_sigma_m > 0.0 ||
                     options.time_offset_sigma_s > 0.0),
      tile_sigma_m_(options.tile_sigma_m),
      tiles_idx_(kRigIdx + (estimates_rig_ ? kRigDim : 0)),
      points_idx_(tiles_idx_ + (options.tile_sigma_m > 0.0 ? kTileDim * kMaxTiles : 0)),
      clones_idx_(points_idx_ + kPointDim * options.max_points),
      covariance_(Eigen::MatrixXd::Zero(clones_idx_ + kCloneDim * kMaxClones,
                                        clones_idx_ + kCloneDim * kMaxClones)) {
  mean_.clones.reserve(kMaxClones);
  mean_.points.resize(static_cast<size_t>(options.max_points));
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
  const Eigen::Matrix<double, kImuDim, Eigen::Dynamic> cross =
      transition.phi * covariance_.block(0, kImuDim, kImuDim, rest);
  covariance_.block(0, kImuDim, kImuDim, rest) = cross;
  covariance_.block(kImuDim, 0, rest, kImuDim) = cross.transpose();
  mean_.imu = end;
  first_ = first;
}

void FilterState::AddClone(int64_t frame_id, int64_t timestamp_ns,
                           const Eigen::Vector3d& imu_rate_rad_s) {
  CAIRN_CHECK(mean_.clones.size() < kMaxClones, "room for one more clone");
  const int old_dim = dim();
  // The clone's error is the pose's error, plus the pose's motion during an error of the time
  // offset.
  covariance_.block(old_dim, 0, kCloneDim, old_dim) = covariance_.block(0, 0, kCloneDim, old_dim);
  if (estimates_rig_) {
    Eigen::Matrix<double, kCloneDim, 1> by_time;
    by_time << mean_.imu.local_from_imu.rotation * imu_rate_rad_s, mean_.imu.velocity_in_local;
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
  mean_.clones.push_back(
      {frame_id, timestamp_ns, mean_.imu.local_from_imu, first_.position_in_local});
}

void FilterState::RemoveClone(int clone) {
  const int newest = static_cast<int>(mean_.clones.size()) - 1;
  const int next_anchor = clone == newest ? newest - 1 : newest;
  for (int slot = 0; slot < static_cast<int>(mean_.points.size()); ++slot) {
    auto& point = mean_.points[static_cast<size_t>(slot)];
    if (point && point->anchor == clone) {
      next_anchor < 0 ? RemovePoint(slot) : MoveAnchor(slot, next_anchor);
    }
    if (point && point->anchor > clone) {
      --point->anchor;
    }
  }
  const int begin = CloneIdx(clone);
  const int old_dim = dim();
  const int after = old_dim - begin - kCloneDim;
  // Moves the rows and columns behind the clone forward, one at a time so that nothing is
  // overwritten early.
  for (int i = 0; i < after; ++i) {
    covariance_.col(begin + i).head(old_dim) = covariance_.col(begin + kCloneDim + i).head(old_dim);
  }
  for (int i = 0; i < after; ++i) {
    covariance_.row(begin + i).head(old_dim) = covariance_.row(begin + kCloneDim + i).head(old_dim);
  }
  covariance_.block(old_dim - kCloneDim, 0, kCloneDim, old_dim).setZero();
  covariance_.block(0, old_dim - kCloneDim, old_dim, kCloneDim).setZero();
  mean_.clones.erase(mean_.clones.begin() + clone);
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

bool FilterState::EnterPoint(int slot, uint64_t track_id, const PointRows& rows) {
  // If the standard deviation is 1 km, the rows do not determine the point.
  if (!(rows.by_point.diagonal().cwiseAbs().minCoeff() > 1e-3)) {
    return false;
  }
  const int newest = static_cast<int>(mean_.clones.size()) - 1;
  StatePoint point;
  point.track_id = track_id;
  SetAnchor(newest, rows.x_in_local, rows.x_in_local, &point);
  const LocatedPoint located = Locate(point);
  // The error of the point in local comes from its coordinates and from its anchor.
  Measurement top = rows.clones;
  top.blocks.push_back({CloneIdx(newest), kCloneDim});
  top.jacobian.conservativeResize(Eigen::NoChange, top.jacobian.cols() + kCloneDim);
  top.jacobian.rightCols<kCloneDim>() = rows.by_point * located.by_anchor;
  point.coordinates += EnterVariable(PointIdx(slot), rows.by_point * located.by_coordinates, top);
  mean_.points[static_cast<size_t>(slot)] = point;
  return true;
}

LocatedPoint FilterState::Locate(int slot) const {
  return Locate(*mean_.points[static_cast<size_t>(slot)]);
}

LocatedPoint FilterState::Locate(const StatePoint& point) const {
  const Clone& anchor = mean_.clones[static_cast<size_t>(point.anchor)];
  LocatedPoint located;
  located.x_in_local = anchor.local_from_imu * point.chart.ToPoint(point.coordinates);
  located.first_x_in_local = anchor.local_from_imu * point.chart.ToPoint(point.chart.origin());
  located.by_anchor << -Skew(located.first_x_in_local - anchor.first_position_in_local),
      Eigen::Matrix3d::Identity();
  located.by_coordinates = anchor.local_from_imu.rotation.toRotationMatrix() *
                           point.chart.Jacobian(point.chart.origin());
  return located;
}

void FilterState::SetAnchor(int clone, const Eigen::Vector3d& first_x_in_local,
                            const Eigen::Vector3d& x_in_local, StatePoint* point) const {
  const Rigid3d imu_from_local = mean_.clones[static_cast<size_t>(clone)].local_from_imu.Inverse();
  point->anchor = clone;
  point->chart =
      PointChart(mean_.rig.cam_from_imu.Inverse().translation, imu_from_local * first_x_in_local);
  point->coordinates = point->chart.FromPoint(imu_from_local * x_in_local);
}

void FilterState::MoveAnchor(int slot, int clone) {
  StatePoint& point = *mean_.points[static_cast<size_t>(slot)];
  const int old_idx = CloneIdx(point.anchor);
  const int new_idx = CloneIdx(clone);
  const LocatedPoint before = Locate(point);
  SetAnchor(clone, before.first_x_in_local, before.x_in_local, &point);
  const LocatedPoint after = Locate(point);
  // The point's position in local does not change: after.by_coordinates * (new coordinates) =
  // before.by_coordinates * (old ones) + before.by_anchor * (old anchor) - after.by_anchor * (new).
  const Eigen::Matrix3d inverse = after.by_coordinates.inverse();
  const Eigen::MatrixXd rows =
      inverse * (before.by_coordinates * covariance_.block(PointIdx(slot), 0, kPointDim, dim()) +
                 before.by_anchor * covariance_.block(old_idx, 0, kCloneDim, dim()) -
                 after.by_anchor * covariance_.block(new_idx, 0, kCloneDim, dim()));
  const Eigen::Matrix3d own =
      (rows.middleCols<kPointDim>(PointIdx(slot)) * before.by_coordinates.transpose() +
       rows.middleCols<kCloneDim>(old_idx) * before.by_anchor.transpose() -
       rows.middleCols<kCloneDim>(new_idx) * after.by_anchor.transpose()) *
      inverse.transpose();
  covariance_.block(PointIdx(slot), 0, kPointDim, dim()) = rows;
  covariance_.block(0, PointIdx(slot), dim(), kPointDim) = rows.transpose();
  covariance_.block<kPointDim, kPointDim>(PointIdx(slot), PointIdx(slot)) =
      0.5 * (own + own.transpose());
}

void FilterState::RemovePoint(int slot) {
  covariance_.block(PointIdx(slot), 0, kPointDim, dim()).setZero();
  covariance_.block(0, PointIdx(slot), dim(), kPointDim).setZero();
  mean_.points[static_cast<size_t>(slot)].reset();
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
  // With standard deviations of 1 km or 60 degrees, the measurement does not determine the
  // transform.
  if (!(by_global.diagonal().cwiseAbs().minCoeff() > 1e-3)) {
    return false;
  }
  // The top rows read r = T g + H x + n, so g = T^-1 (r - H x - n), as an error about the given
  // value.
  Measurement top{{measurement.blocks.begin() + 1, measurement.blocks.end()},
                  rows.block(0, num_dims, num_dims, num_rest_columns),
                  rows.col(rows.cols() - 1).head(num_dims)};
  Measurement rest{top.blocks,
                   rows.block(num_dims, num_dims, num_rows - num_dims, num_rest_columns),
                   rows.col(rows.cols() - 1).tail(num_rows - num_dims)};
  mean_.global_from_local = global_from_local;
  Eigen::VectorXd error = Eigen::VectorXd::Zero(dim());
  error.segment(kGlobalIdx, num_dims) = EnterVariable(kGlobalIdx, by_global, top);
  MoveMean(error);
  Compress(&rest);
  if (!Update(rest)) {
    ForgetGlobal();
    return false;
  }
  return true;
}

Eigen::VectorXd FilterState::EnterVariable(int offset, const Eigen::MatrixXd& by_variable,
                                           const Measurement& top) {
  const Eigen::Index size = by_variable.rows();
  const Eigen::MatrixXd inverse = by_variable.inverse();
  const Eigen::MatrixXd state_by_rows = StateByRows({&top, 1});
  const Eigen::MatrixXd block =
      inverse * InnovationCovariance({&top, 1}, state_by_rows) * inverse.transpose();
  const Eigen::MatrixXd by_state = -inverse * state_by_rows.transpose();
  covariance_.block(offset, 0, size, dim()) = by_state;
  covariance_.block(0, offset, dim(), size) = by_state.transpose();
  covariance_.block(offset, offset, size, size) = 0.5 * (block + block.transpose());
  return inverse * top.residual;
}

void FilterState::ForgetGlobal() {
  mean_.global_from_local.reset();
  covariance_.middleRows<kGlobalDim>(kGlobalIdx).setZero();
  covariance_.middleCols<kGlobalDim>(kGlobalIdx).setZero();
}

}  // namespace cairn::fusion
