#include "core/focal_length.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/error.h"

namespace cairn {
void FocalPrior::Validate(const Camera& camera) const {
  if (!(log_sigma >= kMinLogSigma && log_sigma <= kMaxLogSigma)) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("camera.focalLengthSigma: {} is not within [{}, {}]", log_sigma,
                            kMinLogSigma, kMaxLogSigma));
  }
  if (with_distortion && camera.model() != CameraModel::kSimpleRadial) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("camera.model: the distortion of a {} cannot be estimated, only that of a "
                    "SIMPLE_RADIAL",
                    CameraModelName(camera.model())));
  }
}

Camera CameraOfUnknownFocal(int width_px, int height_px) {
  return Camera(
      CameraModel::kSimpleRadial, width_px, height_px,
      {kUnknownFocalRatio * std::max(width_px, height_px), 0.5 * width_px, 0.5 * height_px, 0.0});
}

Camera WithFocalScaled(const Camera& camera, double factor) {
  std::vector<double> params = camera.params();
  for (int i = 0; i < NumFocalLengths(camera.model()); ++i) {
    params[i] *= factor;
  }
  return Camera(camera.model(), camera.width_px(), camera.height_px(), std::move(params));
}

Camera WithTwoFocalLengths(const Camera& camera) {
  const std::vector<double>& of = camera.params();
  const auto make = [&](CameraModel model, std::vector<double> params) {
    return Camera(model, camera.width_px(), camera.height_px(), std::move(params));
  };
  switch (camera.model()) {
    case CameraModel::kSimplePinhole:
      return make(CameraModel::kPinhole, {of[0], of[0], of[1], of[2]});
    case CameraModel::kSimpleRadial:
      return make(CameraModel::kOpenCv, {of[0], of[0], of[1], of[2], of[3], 0.0, 0.0, 0.0});
    case CameraModel::kRadial:
      return make(CameraModel::kOpenCv, {of[0], of[0], of[1], of[2], of[3], of[4], 0.0, 0.0});
    default:
      return camera;
  }
}

Eigen::Vector2d PrincipalPointPx(const Camera& camera) {
  const int first = NumFocalLengths(camera.model());
  return {camera.params()[first], camera.params()[first + 1]};
}

}  // namespace cairn
