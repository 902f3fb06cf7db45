#include "core/camera_of_this_size.h"

#include <Eigen/Core>
#include <cmath>
#include <utility>
#include <vector>

#include "core/focal_length.h"

namespace cairn {
namespace {

// Principal points of whole pictures are within a few per cent of the middle.
constexpr double kOffMiddleLog = 0.14, kSameLog = 0.1;

// All parameters before the distortion are lengths in pixels.
Camera WithPixelsScaled(const Camera& camera, double factor) {
  std::vector<double> params = camera.params();
  for (int i = 0; i < NumFocalLengths(camera.model()) + 2; ++i) {
    params[i] *= factor;
  }
  return Camera(camera.model(), camera.width_px(), camera.height_px(), std::move(params));
}

Camera WithAxesExchanged(const Camera& camera) {
  std::vector<double> params = camera.params();
  const int num_focals = NumFocalLengths(camera.model());
  std::swap(params[0], params[num_focals - 1]);
  std::swap(params[num_focals], params[num_focals + 1]);
  return Camera(camera.model(), camera.width_px(), camera.height_px(), std::move(params));
}

}  // namespace

std::optional<Camera> CameraOfThisSize(const Camera& stated) {
  const Eigen::Vector2d principal_px = PrincipalPointPx(stated);
  if (!(principal_px.minCoeff() > 0.0)) {
    return std::nullopt;
  }
  const double log_x = std::log(2.0 * principal_px.x() / stated.width_px());
  const double log_y = std::log(2.0 * principal_px.y() / stated.height_px());
  if (std::abs(log_x) < kOffMiddleLog || std::abs(log_y) < kOffMiddleLog) {
    return std::nullopt;
  }
  if (std::abs(log_x - log_y) < kSameLog) {
    return WithPixelsScaled(stated, std::exp(-0.5 * (log_x + log_y)));
  }
  if (std::abs(log_x + log_y) < kSameLog) {
    return WithAxesExchanged(stated);
  }
  return std::nullopt;
}

bool HasAxesExchanged(const Camera& stated, const Camera& other) {
  constexpr double kSamePx = 1e-3;
  const Eigen::Vector2d stated_px = PrincipalPointPx(stated);
  const Eigen::Vector2d other_px = PrincipalPointPx(other);
  return (stated_px - other_px).norm() > kSamePx &&
         (stated_px.reverse() - other_px).norm() <= kSamePx;
}

}  // namespace cairn
