// How measurements change FilterState.
#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <optional>

#include "fusion/filter/filter_state.h"

namespace cairn::fusion {

Eigen::MatrixXd FilterState::StateByRows(std::span<const Measurement> parts) const {
  Eigen::Index num_rows = 0;
  for (const Measurement& part : parts) {
    num_rows += part.num_rows();
  }
  Eigen::MatrixXd state_by_rows = Eigen::MatrixXd::Zero(dim(), num_rows);
  Eigen::Index row = 0;
  for (const Measurement& part : parts) {
    Eigen::Index column = 0;
    for (const StateBlock& block : part.blocks) {
      state_by_rows.middleCols(row, part.num_rows()).noalias() +=
          covariance_.block(0, block.offset, dim(), block.size) *
          part.jacobian.middleCols(column, block.size).transpose();
      column += block.size;
    }
    row += part.num_rows();
  }
  return state_by_rows;
}

Eigen::MatrixXd FilterState::InnovationCovariance(std::span<const Measurement> parts,
                                                  const Eigen::MatrixXd& state_by_rows) {
  Eigen::MatrixXd innovation =
      Eigen::MatrixXd::Identity(state_by_rows.cols(), state_by_rows.cols());
  Eigen::Index row = 0;
  for (const Measurement& part : parts) {
    Eigen::Index column = 0;
    for (const StateBlock& block : part.blocks) {
      innovation.middleRows(row, part.num_rows()).noalias() +=
          part.jacobian.middleCols(column, block.size) *
          state_by_rows.middleRows(block.offset, block.size);
      column += block.size;
    }
    row += part.num_rows();
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

bool FilterState::Update(std::span<const Measurement> parts) {
  const auto is_empty = [](const Measurement& part) { return part.num_rows() == 0; };
  if (std::all_of(parts.begin(), parts.end(), is_empty)) {
    return true;
  }
  const std::optional<Correction> correction = Solve(parts);
  if (correction) {
    Apply(*correction);
  }
  return correction.has_value();
}

std::optional<Correction> FilterState::Solve(std::span<const Measurement> parts) const {
  const Eigen::MatrixXd state_by_rows = StateByRows(parts);
  if (state_by_rows.cols() == 0) {
    return std::nullopt;
  }
  Eigen::VectorXd residual(state_by_rows.cols());
  Eigen::Index row = 0;
  for (const Measurement& part : parts) {
    residual.segment(row, part.num_rows()) = part.residual;
    row += part.num_rows();
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(InnovationCovariance(parts, state_by_rows));
  const Eigen::VectorXd whitened = llt.matrixL().solve(residual);
  if (llt.info() != Eigen::Success || !whitened.allFinite()) {
    return std::nullopt;
  }
  // With S = L L' and W = L^-1 H P, the correction is W' L^-1 r, and the covariance loses W' W.
  Correction correction;
  correction.gain = state_by_rows.transpose();
  llt.matrixL().solveInPlace(correction.gain);
  correction.error = correction.gain.transpose() * whitened;
  correction.error.segment(tiles_idx_, points_idx_ - tiles_idx_).setZero();  // Tile offsets stay.
  return correction;
}

void FilterState::Apply(const Correction& correction) {
  const int num_tiles_dims = points_idx_ - tiles_idx_;
  const Eigen::MatrixXd tiles =
      covariance_.block(tiles_idx_, tiles_idx_, num_tiles_dims, num_tiles_dims);
  auto lower = covariance_.topLeftCorner(dim(), dim()).selfadjointView<Eigen::Lower>();
  lower.rankUpdate(correction.gain.transpose(), -1.0);
  covariance_.topLeftCorner(dim(), dim()).triangularView<Eigen::StrictlyUpper>() =
      covariance_.topLeftCorner(dim(), dim()).transpose();
  covariance_.block(tiles_idx_, tiles_idx_, num_tiles_dims, num_tiles_dims) = tiles;
  MoveMean(correction.error);
}

void FilterState::MoveMean(const Eigen::VectorXd& error) {
  const auto turn = [&error](int offset, Eigen::Quaterniond* rotation) {
    *rotation = (ExpSo3(error.segment<3>(offset)) * *rotation).normalized();
  };
  MoveBy(error.head<kImuDim>(), &mean_.imu);
  if (mean_.global_from_local) {
    const Eigen::Vector3d rotation(error[kGlobalIdx + 4], error[kGlobalIdx + 5],
                                   error[kGlobalIdx + 3]);
    *mean_.global_from_local =
        *mean_.global_from_local * Rigid3d(ExpSo3(rotation), error.segment<3>(kGlobalIdx));
  }
  if (estimates_rig_) {
    turn(kRigIdx, &mean_.rig.cam_from_imu.rotation);
    mean_.rig.cam_from_imu.translation += error.segment<3>(kRigIdx + 3);
    mean_.rig.time_offset_s += error[kRigIdx + 6];
  }
  for (size_t i = 0; i < mean_.points.size(); ++i) {
    if (auto& point = mean_.points[i]) {
      point->coordinates += error.segment<3>(PointIdx(static_cast<int>(i)));
    }
  }
  for (size_t i = 0; i < mean_.clones.size(); ++i) {
    const int offset = CloneIdx(static_cast<int>(i));
    turn(offset, &mean_.clones[i].local_from_imu.rotation);
    mean_.clones[i].local_from_imu.translation += error.segment<3>(offset + 3);
  }
}

double FilterState::LinearizationDoubt(const Eigen::VectorXd& error) const {
  constexpr double kMaxTurnRad = 3e-3;
  constexpr double kMaxShiftM = 0.02;
  double doubt = 0.0;
  for (int i = 0; i < static_cast<int>(mean_.clones.size()); ++i) {
    const int offset = CloneIdx(i);
    doubt = std::max({doubt, error.segment<3>(offset).norm() / kMaxTurnRad,
                      error.segment<3>(offset + 3).norm() / kMaxShiftM});
  }
  return doubt;
}

}  // namespace cairn::fusion
