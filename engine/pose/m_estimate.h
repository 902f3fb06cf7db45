// Shared by the covariances of robust estimates.
#ifndef CAIRN_ENGINE_POSE_M_ESTIMATE_H_
#define CAIRN_ENGINE_POSE_M_ESTIMATE_H_

#include <algorithm>

#include "engine/pose/pose_residuals.h"

namespace cairn {

// Residual of an observation that does not project, in standard deviations.
inline constexpr double kGrossError = 100.0;

// Neighboring photos place the keypoints of a patch alike, so the distances of all landmarks that
// were triangulated from them err alike, too: by this share of their standard deviations, which no
// number of landmarks averages out. Fitted to real photos (docs/decisions/0080).
inline constexpr double kCommonDistanceShare = 0.1;

// Compares the residuals of an estimate with their standard deviations. Residuals r are in standard
// deviations; w is the robust weight.
struct ResidualSpread {
  double sum_sq_weight = 0.0;    // Sum of w^2.
  double sum_sq_weighted = 0.0;  // Sum of w^2 r'r.

  // Returns the factor on the inverse information that gives the asymptotic covariance of an
  // M-estimate (Huber 1981, section 7.6): mean(psi^2) / mean(psi')^2. For the Cauchy loss on
  // two-dimensional residuals, psi = w r and psi' averages to w^2. The stated standard deviations,
  // a factor of 1, count as kPriorDegreesOfFreedom residuals, so that few residuals that happen to
  // be small do not make a pose exact.
  double CovarianceScale(double num_observations, int num_params) const {
    if (!(sum_sq_weight > 0.0)) {
      return 1.0;
    }
    constexpr double kPriorDegreesOfFreedom = 4.0;
    const double degrees_of_freedom = std::max(0.0, 2.0 * num_observations - num_params);
    const double mean_slope = sum_sq_weight / num_observations;
    const double sum_sq = sum_sq_weighted / (mean_slope * mean_slope);
    return (kPriorDegreesOfFreedom + sum_sq) / (kPriorDegreesOfFreedom + degrees_of_freedom);
  }
};

// Information that keeps the variance finite in directions that observations leave free.
inline PoseTangent InformationFloor() {
  PoseTangent floor;
  floor << Eigen::Vector3d::Constant(1.0 / 9.0), Eigen::Vector3d::Constant(1e-6);
  return floor;
}

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_M_ESTIMATE_H_
