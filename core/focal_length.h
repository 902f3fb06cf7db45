// Cameras whose focal length and principal point are uncertain.
#ifndef CAIRN_CORE_FOCAL_LENGTH_H_
#define CAIRN_CORE_FOCAL_LENGTH_H_

#include <Eigen/Core>

#include "core/camera.h"

namespace cairn {

// How well the focal length of a camera is known.
struct FocalPrior {
  // Standard deviation of the logarithm of the focal length; the mean is the camera's.
  double log_sigma = kUnknownLogSigma;
  // True if the distortion is unknown, too; the camera is then a SIMPLE_RADIAL.
  bool with_distortion = false;

  // For a camera that nobody calibrated. Two standard deviations around kUnknownFocalRatio cover
  // lenses from 19 mm (wide) to 50 mm (tele), as focal lengths for 35 mm film.
  static constexpr double kUnknownLogSigma = 0.25;
  static constexpr double kMinLogSigma = 1e-4;
  static constexpr double kMaxLogSigma = 0.5;

  // Throws Error(kBadInput) if log_sigma is outside [kMinLogSigma, kMaxLogSigma], or if
  // with_distortion is set and the camera is not a SIMPLE_RADIAL.
  void Validate(const Camera& camera) const;
};

// The camera of an answer, if it was estimated.
struct CameraEstimate {
  Camera camera;
  double focal_sigma_px = 0.0;  // Standard deviation of the focal length.
  // The focal length that the query stated, or that was assumed for it, and its standard deviation.
  double assumed_focal_px = 0.0;
  double assumed_focal_sigma_px = 0.0;
  // The inliers contradict that focal length by more than three standard deviations.
  bool focal_disagrees = false;
  // The inliers contradict that the optical axis is near the middle: the photo is part of another.
  bool is_off_center = false;
};

// The assumed focal length of an uncalibrated camera, in units of the image's long side.
inline constexpr double kUnknownFocalRatio = 0.85;

// Returns a SIMPLE_RADIAL camera with the assumed focal length, no distortion, and the principal
// point in the middle. Throws Error(kBadInput) as Camera does.
Camera CameraOfUnknownFocal(int width_px, int height_px);

// Returns the camera with its focal lengths multiplied by `factor` (positive); the other parameters
// stay.
Camera WithFocalScaled(const Camera& camera, double factor);

// Returns the camera in a model that has a focal length for each axis, if there is one.
Camera WithTwoFocalLengths(const Camera& camera);

// Returns the pixel of the optical axis.
Eigen::Vector2d PrincipalPointPx(const Camera& camera);

}  // namespace cairn

#endif  // CAIRN_CORE_FOCAL_LENGTH_H_
