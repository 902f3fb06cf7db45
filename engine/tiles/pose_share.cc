#include "engine/tiles/pose_share.h"

#include <algorithm>
#include <cmath>

#include "core/angles.h"

namespace cairn {
namespace {

double SqDistanceFromPrior(const SearchRegion& region, const Eigen::Vector3d& center_in_anchor) {
  return (center_in_anchor.head<2>() - region.prior_xy_in_anchor).squaredNorm();
}

// Returns the logarithm of the density of positions, per square meter.
double LogPositionDensity(const SearchRegion& region, const Eigen::Vector3d& center_in_anchor) {
  constexpr double kFreedom = 3.0;
  constexpr double kMinLengthM = 1.0;  // Positions closer together than this are not distinguished.
  if (!region.has_prior) {
    return -std::log(std::max(kMinLengthM * kMinLengthM, region.area_m2));
  }
  const double sigma_m = std::max(kMinLengthM, region.prior_sigma_m);
  const double sq_sigma = sigma_m * sigma_m;
  return -std::log(2.0 * kPi * sq_sigma) -
         0.5 * (kFreedom + 2.0) *
             std::log1p(SqDistanceFromPrior(region, center_in_anchor) / (kFreedom * sq_sigma));
}

}  // namespace

double LogPoseShare(const SearchRegion& region, const Eigen::Vector3d& center_in_anchor,
                    const PoseEstimate& estimate) {
  constexpr double kHeightsM = 5.0, kHeadingsRad = 2.0 * kPi;
  const double log_density = LogPositionDensity(region, center_in_anchor) -
                             std::log(kHeightsM * kHeadingsRad) + estimate.log_tilt_density;
  return std::min(0.0, log_density + estimate.log_volume) + estimate.log_camera_share;
}

Eigen::Vector3d PriorCenter(const SearchRegion& region) {
  return {region.prior_xy_in_anchor.x(), region.prior_xy_in_anchor.y(), 0.0};
}

bool DisagreesWithPrior(const SearchRegion& region, const Eigen::Vector3d& center_in_anchor) {
  constexpr double kMaxSigmas = 3.0;
  return region.has_prior && SqDistanceFromPrior(region, center_in_anchor) >
                                 std::pow(kMaxSigmas * region.prior_sigma_m, 2);
}

}  // namespace cairn
