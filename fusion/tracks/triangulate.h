// The point that explains a track, given the poses it was seen from.
#ifndef CAIRN_FUSION_TRACKS_TRIANGULATE_H_
#define CAIRN_FUSION_TRACKS_TRIANGULATE_H_

#include <Eigen/Core>
#include <optional>
#include <span>

#include "core/camera.h"
#include "fusion/filter/camera_view.h"

namespace cairn::fusion {

struct TriangulateOptions {
  double min_depth_m = 0.2;
  double max_depth_m = 150.0;  // Beyond it a point is a direction and its depth a guess.
  // Largest standard deviation of the depth relative to the depth. Beyond it the depth's error is
  // not Gaussian, and a filter that linearises at such points grows overconfident, in yaw first;
  // below it, far points are left out that tell the rotation. Measured with
  // cairn_fusion_consistency; see docs/math/fusion.md.
  double max_relative_depth_sigma = 0.12;
  int max_iterations = 5;

  void Validate() const;
};

// One sight of the point.
struct Sight {
  const CameraView* view;
  Eigen::Vector2d pixel;
  Eigen::Vector3d ray_in_cam;  // Unit vector through the pixel.
};

// What is known of the point beforehand: normal' (x_in_local - point) = 0 within sigma_m.
struct PlanePrior {
  Eigen::Vector3d x_in_local;  // Where the search for the point begins.
  Eigen::Vector3d normal_in_local;
  double sigma_m = 0.0;  // Positive.
};

// Least squares of the reprojection errors: the point nearest to all rays first, or that of the
// prior, then Gauss-Newton in the image coordinates and inverse depth of the last sight. Nothing
// with fewer than two sights, with rays that do not meet in front of every camera, or outside the
// limits of the options. `sigma_px` is the standard deviation of a pixel per axis.
std::optional<Eigen::Vector3d> Triangulate(const Camera& camera, std::span<const Sight> sights,
                                           double sigma_px, const TriangulateOptions& options,
                                           const std::optional<PlanePrior>& prior = std::nullopt);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRACKS_TRIANGULATE_H_
