#include "ingest/place/placement_accuracy.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/angles.h"
#include "core/check.h"
#include "core/error.h"
#include "core/radius68.h"
#include "core/statistics.h"

namespace cairn {
namespace {

constexpr double kNumParameters = 7.0;  // Of a similarity.
// Long enough to tell shared errors from noise, and many enough to have a variance.
constexpr size_t kMaxStretches = 8;
constexpr size_t kMinPositionsOfStretch = 3;

double Squared(double value) { return value * value; }

double MedianSquaredAccuracy(const std::vector<FittedPosition>& positions) {
  std::vector<double> squares;
  for (const FittedPosition& position : positions) {
    squares.push_back(Squared(position.accuracy_m / kRadius68PerSigma3d));
  }
  return Median(std::move(squares));
}

// The variance of the positions per axis. The fit has taken as many degrees of freedom as it has
// parameters, but the tilt is known beside the positions, so three positions leave some.
double NoiseVariance(const std::vector<FittedPosition>& positions) {
  double sum_sq_m = 0.0;
  for (const FittedPosition& position : positions) {
    sum_sq_m += position.residual_m.squaredNorm();
  }
  const double num_residuals = 3.0 * static_cast<double>(positions.size());
  return sum_sq_m / std::max(num_residuals - kNumParameters, 1.0);
}

// The mean over equal stretches of the squared mean residual, per axis.
double VarianceOfStretches(const std::vector<FittedPosition>& positions, size_t num_stretches) {
  double sum_sq_m = 0.0;
  for (size_t i = 0; i < num_stretches; ++i) {
    const size_t begin = positions.size() * i / num_stretches;
    const size_t end = positions.size() * (i + 1) / num_stretches;
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    for (size_t k = begin; k < end; ++k) {
      sum_m += positions[k].residual_m;
    }
    sum_sq_m += (sum_m / static_cast<double>(end - begin)).squaredNorm();
  }
  return sum_sq_m / (3.0 * static_cast<double>(num_stretches));
}

// The mean over the axes of the variance of the direction. Positions along a line do not determine
// the rotation about the line; the horizontal axes of the cameras do.
double DirectionVariance(const std::vector<FittedPosition>& positions, double noise,
                         double upright_sigma_rad) {
  const auto num_positions = static_cast<double>(positions.size());
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const FittedPosition& position : positions) {
    middle += position.center_in_enu / num_positions;
  }
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const FittedPosition& position : positions) {
    const Eigen::Vector3d offset = position.center_in_enu - middle;
    scatter += offset * offset.transpose();
  }
  const Eigen::Vector3d along =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter, Eigen::EigenvaluesOnly).eigenvalues();
  const double of_cameras =
      upright_sigma_rad > 0.0 ? num_positions / Squared(upright_sigma_rad) : 0.0;
  double variance = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    // Ascending: the positions say least about the last axis. The cameras know two of the three.
    const double of_positions = (along.sum() - along[axis]) / std::max(noise, 1e-12);
    const double information = of_positions + (axis > 0 ? of_cameras : 0.0);
    variance += 1.0 / std::max(information, 0.1) / 3.0;
  }
  return variance;
}

}  // namespace

PlacementAccuracy EstimatePlacementAccuracy(const std::vector<FittedPosition>& positions,
                                            double upright_sigma_rad) {
  CAIRN_CHECK(!positions.empty(), "an accuracy needs positions");
  const auto num_positions = static_cast<double>(positions.size());
  const double stated = MedianSquaredAccuracy(positions);
  const double noise = NoiseVariance(positions);
  const double shared = std::max(0.0, stated - noise);
  double of_fit = noise * kNumParameters / (3.0 * num_positions);
  double off_after_fit = 0.0;
  double times_chance = 1.0;
  const size_t num_stretches = std::min(kMaxStretches, positions.size() / kMinPositionsOfStretch);
  if (num_stretches >= 2 && noise > 0.0) {
    const double by_chance = noise * static_cast<double>(num_stretches) / num_positions;
    const double of_stretches = VarianceOfStretches(positions, num_stretches);
    times_chance = std::max(1.0, of_stretches / by_chance);
    off_after_fit = std::max(0.0, of_stretches - by_chance);
  }
  of_fit *= times_chance;
  const double of_direction = DirectionVariance(positions, noise * times_chance, upright_sigma_rad);
  return {.position_m = kRadius68PerSigma3d * std::sqrt(of_fit + off_after_fit + shared),
          .rotation_rad = kRadius68PerSigma3d * std::sqrt(of_direction)};
}

void RequireKnownUp(const PlacementAccuracy& accuracy) {
  constexpr double kMaxTiltRad = 5.0 * kRadPerDeg;
  if (accuracy.rotation_rad > kMaxTiltRad) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("georegistration: the positions alone tell which way is up to {:.0f} "
                            "degrees only (allowed: {:.0f}), as they lie near a line or err much; "
                            "let the photos tell it, too (--up auto), or say how they were held "
                            "(--up top, left, right, bottom or down)",
                            accuracy.rotation_rad * kDegPerRad, kMaxTiltRad * kDegPerRad));
  }
}

}  // namespace cairn
