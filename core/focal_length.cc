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

Eigen::Vector2d PrincipalPointPx(const Camera& camera) {
  const int first = NumFocalLengths(camera.model());
  return {camera.params()[first], camera.params()[first + 1]};
}

}  // namespace cairn
