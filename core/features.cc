#include "core/features.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/angles.h"
#include "core/error.h"
#include "core/keypoint_shape.h"

namespace cairn {

void ValidateFeatures(const FeatureSet& features, const char* what) {
  if (features.descriptors.rows() != features.size()) {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: {} keypoints but {} descriptors", what,
                                                  features.size(), features.descriptors.rows()));
  }
  for (int i = 0; i < features.size(); ++i) {
    const Keypoint& keypoint = features.keypoints[i];
    const bool finite = std::isfinite(keypoint.x_px) && std::isfinite(keypoint.y_px) &&
                        std::isfinite(keypoint.scale_px) && !std::isinf(keypoint.orientation_rad);
    if (!finite || !features.descriptors.row(i).allFinite()) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("{}: feature {} holds a number that is not finite", what, i));
    }
    if (keypoint.scale_px < 0.0f) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("{}: keypoint {} has scale {}; it must be > 0, or 0 if it is unknown",
                              what, i, keypoint.scale_px));
    }
  }
}

std::optional<double> GravityRectifiedOrientationRad(const Camera& camera, const Keypoint& keypoint,
                                                     const Eigen::Vector3d& down_in_cam) {
  if (!HasOrientation(keypoint)) {
    return std::nullopt;
  }
  const auto ray_in_cam = camera.Unproject({keypoint.x_px, keypoint.y_px});
  if (!ray_in_cam) {
    return std::nullopt;
  }
  constexpr double kMinSinAngle = 0.0523;  // 3 degrees from the vertical.
  if (ray_in_cam->cross(down_in_cam).norm() < kMinSinAngle) {
    return std::nullopt;
  }
  Eigen::Matrix<double, 2, 3> jacobian;
  if (!camera.ProjectWithJacobian(*ray_in_cam, &jacobian)) {
    return std::nullopt;
  }
  const Eigen::Vector2d down_in_image = jacobian * down_in_cam;
  return WrapAngleRad(keypoint.orientation_rad - std::atan2(down_in_image.y(), down_in_image.x()));
}

double WrapAngleRad(double angle_rad) {
  const double wrapped = std::remainder(angle_rad, 2.0 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

}  // namespace cairn
