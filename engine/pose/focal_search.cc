#include "engine/pose/focal_search.h"

#include <algorithm>
#include <cmath>

namespace cairn {

CameraPrior CameraPriorOf(const LocalizeQuery& query) {
  // The root mean square of how far principal points of calibrated cameras are off the middle, as a
  // share of the long side: KITTI 1.1 % and 0.2 %, Herz-Jesus 0.5 % and 0.5 %.
  constexpr double kUnknownPrincipalPointSigma = 0.0065;
  CameraPrior prior = {query.camera, query.focal.value_or(FocalPrior{kAssumedFocalLogSigma})};
  const Camera& camera = query.camera;
  const Eigen::Vector2d middle_px(0.5 * camera.width_px(), 0.5 * camera.height_px());
  // A calibration puts the principal point elsewhere.
  const bool is_calibrated = !query.focal || PrincipalPointPx(camera) != middle_px;
  prior.principal_point_sigma = is_calibrated ? 0.0 : kUnknownPrincipalPointSigma;
  return prior;
}

CameraPrior OffCenterPrior(CameraPrior prior) {
  constexpr double kOffCenterSigma = 0.2;
  prior.is_off_center = true;
  prior.principal_point_sigma = kOffCenterSigma;
  prior.focal.log_sigma = FocalPrior::kMaxLogSigma;
  return prior;
}

std::vector<double> FocalGuesses(const FocalPrior& prior) {
  constexpr double kMaxLogStep = 0.15;
  const double reach = 3.0 * prior.log_sigma;
  const int num_steps = prior.log_sigma > kMaxTrustedFocalLogSigma
                            ? static_cast<int>(std::ceil(reach / kMaxLogStep))
                            : 0;
  std::vector<double> factors = {1.0};
  for (int i = 1; i <= num_steps; ++i) {
    const double factor = std::exp(reach * i / num_steps);
    factors.insert(factors.end(), {1.0 / factor, factor});
  }
  return factors;
}

double LogCameraShare(const CameraPrior& prior, const RefinedCamera& refined) {
  constexpr double kFreedom = 3.0;
  const auto log_density = [&](double num_dimensions, double sq_deviation) {
    return -0.5 * (kFreedom + num_dimensions) * std::log1p(sq_deviation / kFreedom);
  };
  const double deviation =
      std::log(refined.camera.focal_px() / prior.camera.focal_px()) / prior.focal.log_sigma;
  const double log_width = std::log(refined.focal_log_sigma / prior.focal.log_sigma);
  const double shift_px =
      (PrincipalPointPx(refined.camera) - PrincipalPointPx(prior.camera)).norm();
  const double sigma_px =
      prior.principal_point_sigma * std::max(prior.camera.width_px(), prior.camera.height_px());
  const double sq_shift = sigma_px > 0.0 ? std::pow(shift_px / sigma_px, 2) : 0.0;
  return std::min(0.0, log_width) + log_density(1.0, deviation * deviation) +
         log_density(2.0, sq_shift);
}

CameraEstimate MakeCameraEstimate(const CameraPrior& prior, const RefinedCamera& refined) {
  CameraEstimate estimate;
  estimate.camera = refined.camera;
  estimate.focal_sigma_px = refined.focal_log_sigma * refined.camera.focal_px();
  estimate.assumed_focal_px = prior.camera.focal_px();
  estimate.assumed_focal_sigma_px = prior.focal.log_sigma * prior.camera.focal_px();
  estimate.is_off_center = refined.is_off_center;
  const double log_ratio = std::log(refined.camera.focal_px() / prior.camera.focal_px());
  // The prior of a photo off center says nothing about its focal length.
  estimate.focal_disagrees =
      refined.is_off_center
          ? std::abs(log_ratio) > RefinedCamera::kMaxDisagreement *
                                      std::hypot(prior.focal.log_sigma, refined.focal_log_sigma)
          : refined.FocalDisagrees();
  return estimate;
}

}  // namespace cairn
