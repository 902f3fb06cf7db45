#include "ingest/colmap/model_errors.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/statistics.h"

namespace cairn {
namespace {

constexpr double kMaxPx = 8.0, kMaxRelative = 0.005;
// Of a point that is behind the camera, or outside of its view.
constexpr double kNotInViewPx = 1e6;

}  // namespace

void ModelErrors::Add(const Reconstruction& reconstruction, const ReconLandmark& landmark) {
  for (const ReconObservation& observation : landmark.observations) {
    const ReconImage& image = reconstruction.images[observation.image_idx];
    const Camera& camera = reconstruction.cameras[image.camera_idx];
    const Keypoint& keypoint = image.features.keypoints[observation.keypoint_idx];
    const auto pixel = camera.Project(image.cam_from_world * landmark.x_in_world);
    const double error_px =
        pixel ? (*pixel - Eigen::Vector2d(keypoint.x_px, keypoint.y_px)).norm() : kNotInViewPx;
    errors_px_.push_back(error_px);
    relative_.push_back(error_px / std::max(camera.width_px(), camera.height_px()));
  }
}

std::optional<std::string> ModelErrors::Fault() const {
  if (errors_px_.empty()) {
    return std::nullopt;
  }
  const double median_px = Median(errors_px_);
  if (median_px <= kMaxPx || Median(relative_) <= kMaxRelative) {
    return std::nullopt;
  }
  return fmt::format(
      "its points are not where its photos see them: half of the {} observations are {} or more "
      "off. Cameras, poses, points and keypoints have to be of one reconstruction; do the cameras "
      "have the parameters of another size of the photos?",
      errors_px_.size(),
      median_px < kNotInViewPx ? fmt::format("{:.0f} px", median_px) : "out of view");
}

}  // namespace cairn
