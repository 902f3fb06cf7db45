#include "engine/pose/focal_search.h"

#include <algorithm>
#include <cmath>

namespace cairn {

CameraPrior CameraPriorOf(const LocalizeQuery& query) {
  // The root mean square of how far principal points of calibrated cameras are off the middle, as a
  // share of the long side: KITTI 1.1 % and 0.2 %, Herz-Jesus 0.5 % and 0.5 %.
  constexpr double kUnknownPrincipalPointSigma = 0.0065;
  CameraPrior prior = {query.camera, query.focal.value_or(FocalPrior{kAssumedFocalLogSigma})};
  prior.principal_point_sigma = prior.focal.with_distortion ? kUnknownPrincipalPointSigma : 0.0;
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
  const double deviation =
      std::log(refined.camera.focal_px() / prior.camera.focal_px()) / prior.focal.log_sigma;
  const double log_width = std::log(refined.focal_log_sigma / prior.focal.log_sigma);
  return std::min(0.0, log_width) -
         0.5 * (kFreedom + 1.0) * std::log1p(deviation * deviation / kFreedom);
}

CameraEstimate MakeCameraEstimate(const CameraPrior& prior, const RefinedCamera& refined) {
  CameraEstimate estimate;
  estimate.camera = refined.camera;
  estimate.focal_sigma_px = refined.focal_log_sigma * refined.camera.focal_px();
  estimate.assumed_focal_px = prior.camera.focal_px();
  estimate.assumed_focal_sigma_px = prior.focal.log_sigma * prior.camera.focal_px();
  estimate.focal_disagrees = refined.FocalDisagrees();
  return estimate;
}

}  // namespace cairn
