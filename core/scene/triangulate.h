// Computes a landmark's position and its uncertainty from observations with known cameras.
#ifndef CAIRN_CORE_SCENE_TRIANGULATE_H_
#define CAIRN_CORE_SCENE_TRIANGULATE_H_

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/rigid3.h"
#include "core/scene/reconstruction.h"

namespace cairn {

// One observation of a point. Does not own `camera`.
struct PointObservation {
  const Camera* camera = nullptr;
  Rigid3d cam_from_world;
  Eigen::Vector2d pixel;
  double sigma_px = 1.0;  // Standard deviation of the pixel, per axis.
};

// Standard deviation of a SIFT keypoint's position, per axis: half a pixel for small keypoints,
// growing with the scale of large ones.
double KeypointSigmaPx(double scale_px);

// What TriangulatePoint needs of each observation of a landmark, in their order.
std::vector<PointObservation> PointObservationsOf(const Reconstruction& reconstruction,
                                                  const ReconLandmark& landmark);

// Minimizes the reprojection errors under Cauchy's loss by damped Gauss-Newton, starting at the
// point nearest to all rays. Returns nothing if there are fewer than two observations, if the rays
// are parallel, or if the point ends up behind a camera or outside its field of view. Linear in the
// number of observations.
std::optional<Eigen::Vector3d> TriangulatePoint(std::span<const PointObservation> observations);

struct PointUncertainty {
  // Covariance of the position in squared world units, derived from the pixel sigmas of the
  // observations. It is scaled up if the observations disagree by more than their sigmas.
  Eigen::Matrix3d covariance;
  double median_error_px = 0.0;  // Median of the reprojection errors.

  // Root mean square of the standard deviations along the axes, world units.
  double Sigma() const;
};

// Returns nothing if the point is not visible in an observation or if the observations do not
// determine the point.
std::optional<PointUncertainty> EstimateUncertainty(std::span<const PointObservation> observations,
                                                    const Eigen::Vector3d& x_in_world);

}  // namespace cairn

#endif  // CAIRN_CORE_SCENE_TRIANGULATE_H_
