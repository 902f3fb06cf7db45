#include "engine/answer/score_calibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/radius68.h"
#include "core/require.h"

namespace cairn {
namespace {

constexpr double kCorrectM = 3.0;

// Returns the share within `radius_m` of an isotropic 3-D Gaussian that has 68 % within
// `radius68_m` (Maxwell's distribution).
double ShareWithin(double radius_m, double radius68_m) {
  const double sigmas = radius_m * kRadius68PerSigma3d / std::max(1e-9, radius68_m);
  return std::erf(sigmas / std::numbers::sqrt2) -
         std::sqrt(2.0 * std::numbers::inv_pi) * sigmas * std::exp(-0.5 * sigmas * sigmas);
}

}  // namespace

void ScoreCalibration::Validate() const {
  const auto is_positive = [](double value) { return value > 0.0 && std::isfinite(value); };
  RequireOption(is_positive(confidence_slope) && std::isfinite(confidence_offset),
                "answer.calibration: the confidence needs a positive slope and a finite offset");
  RequireOption(is_positive(false_alarm_slope) && std::isfinite(false_alarm_start),
                "answer.calibration: the false alarm rate needs a positive slope and a finite "
                "start");
  RequireOption(is_positive(position_accuracy_factor) && is_positive(rotation_accuracy_factor),
                "answer.calibration: the accuracy factors must be positive and finite");
  RequireOption(map_accuracy_m >= 0.0 && std::isfinite(map_accuracy_m),
                "answer.calibration.map_accuracy_m must be finite and not negative");
}

double ScoreCalibration::Confidence(double score, double position_accuracy_m) const {
  const double logit = confidence_slope * std::log(std::max(score, 1e-9)) + confidence_offset;
  return ShareWithin(kCorrectM, position_accuracy_m) / (1.0 + std::exp(-logit));
}

double ScoreCalibration::FalseAlarmRate(double score) const {
  return std::min(1.0, std::exp(-false_alarm_slope * (score - false_alarm_start)));
}

Eigen::Matrix<double, 6, 6> ScoreCalibration::Calibrated(
    const Eigen::Matrix<double, 6, 6>& predicted, double in_map_accuracy_m) const {
  Eigen::Matrix<double, 6, 1> factors;
  factors << Eigen::Vector3d::Constant(rotation_accuracy_factor),
      Eigen::Vector3d::Constant(position_accuracy_factor);
  const Eigen::Matrix<double, 6, 6> calibrated =
      factors.asDiagonal() * predicted * factors.asDiagonal();
  const double radius_m = Radius68(calibrated.bottomRightCorner<3, 3>());
  const double growth = in_map_accuracy_m / std::max(radius_m, 1e-9);
  return (1.0 + growth * growth) * calibrated;
}

}  // namespace cairn
