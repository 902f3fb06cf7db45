// Cameras whose focal length is not known for sure.
#ifndef CAIRN_CORE_FOCAL_LENGTH_H_
#define CAIRN_CORE_FOCAL_LENGTH_H_

#include <Eigen/Core>

#include "core/camera.h"

namespace cairn {

// How well the focal length of a camera is known.
struct FocalPrior {
  // Standard deviation of the logarithm of the focal length about that of the camera.
  double log_sigma = kUnknownLogSigma;
  // The distortion is not known either; the camera is a SIMPLE_RADIAL.
  bool with_distortion = false;

  // Of a camera that nobody measured: two standard deviations about kUnknownFocalRatio reach from
  // wide lenses of 19 mm to tele ones of 50 mm (35 mm film).
  static constexpr double kUnknownLogSigma = 0.25;
  static constexpr double kMinLogSigma = 1e-4;
  static constexpr double kMaxLogSigma = 0.5;

  // Throws Error(kBadInput) if log_sigma is outside [kMinLogSigma, kMaxLogSigma], or the camera's
  // distortion is to be found and it is no SIMPLE_RADIAL.
  void Validate(const Camera& camera) const;
};

// The focal length of a camera that nobody measured, in units of the image's long side.
inline constexpr double kUnknownFocalRatio = 0.85;

// A SIMPLE_RADIAL camera of that focal length, without distortion, its principal point in the
// middle. Throws Error(kBadInput) as Camera does.
Camera CameraOfUnknownFocal(int width_px, int height_px);

// The camera with its focal lengths multiplied by `factor` (positive); all else stays.
Camera WithFocalScaled(const Camera& camera, double factor);

// The pixel of the optical axis.
Eigen::Vector2d PrincipalPointPx(const Camera& camera);

}  // namespace cairn

#endif  // CAIRN_CORE_FOCAL_LENGTH_H_
