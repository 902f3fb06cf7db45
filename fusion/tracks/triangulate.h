// Triangulates the point of a track from observations at known poses.
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
  // Beyond this depth, the observations tell the direction of a point but hardly its depth.
  double max_depth_m = 150.0;

  void Validate() const;
};

// One observation of the point.
struct PosedObservation {
  const CameraView* view;
  Eigen::Vector2d pixel;
  Eigen::Vector3d ray_in_cam;  // Unit vector through the pixel.
};

// Prior knowledge of the point: normal' (x_in_local - point) = 0 with standard deviation sigma_m.
struct PlanePrior {
  Eigen::Vector3d x_in_local;  // Where the search for the point starts.
  Eigen::Vector3d normal_in_local;
  double sigma_m = 0.0;  // Positive.
};

// Minimizes the reprojection errors. The search starts at the prior's point, or else at the point
// that the views see nearest to their rays, and continues with Gauss-Newton in the image
// coordinates and inverse depth of the last observation. `sigma_px` is the standard deviation of a
// pixel per axis. Returns nullopt if there are fewer than two observations, if the rays do not meet
// in front of every camera, or if the result exceeds the limits in `options`.
std::optional<Eigen::Vector3d> Triangulate(const Camera& camera,
                                           std::span<const PosedObservation> observations,
                                           double sigma_px, const TriangulateOptions& options,
                                           const std::optional<PlanePrior>& prior = std::nullopt);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRACKS_TRIANGULATE_H_
