// A landmark's position and its uncertainty from its observations, the cameras being known.
#ifndef CAIRN_INGEST_SFM_TRIANGULATE_H_
#define CAIRN_INGEST_SFM_TRIANGULATE_H_

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/rigid3.h"
#include "ingest/sfm/reconstruction.h"

namespace cairn {

// One observation of a point. `camera` is not owned.
struct PointView {
  const Camera* camera = nullptr;
  Rigid3d cam_from_world;
  Eigen::Vector2d pixel;
  double sigma_px = 1.0;  // Standard deviation of the pixel, per axis.
};

// Standard deviation of where SIFT finds a keypoint, per axis: half a pixel for small ones, growing
// with the scale of large ones.
double KeypointSigmaPx(double scale_px);

// The views of a landmark, in the order of its observations.
std::vector<PointView> ViewsOf(const Reconstruction& reconstruction, const ReconLandmark& landmark);

// Least squares of reprojection errors under Cauchy's loss, by damped Gauss-Newton from the point
// nearest to all rays. Nothing if there are fewer than two views, if the rays are parallel, or if
// the point ends up behind a camera or beyond its field of view. Linear in the number of views.
std::optional<Eigen::Vector3d> TriangulatePoint(std::span<const PointView> views);

struct PointUncertainty {
  // Of the position, in world units squared; follows from the views' pixel sigmas. It is scaled up
  // if the observations disagree by more than their sigmas say.
  Eigen::Matrix3d covariance;
  double median_error_px = 0.0;  // Of the reprojection errors.

  // Root mean square standard deviation over the axes, world units.
  double Sigma() const;
};

// Nothing if a view does not see the point at all or the views do not determine it.
std::optional<PointUncertainty> EstimateUncertainty(std::span<const PointView> views,
                                                    const Eigen::Vector3d& x_in_world);

}  // namespace cairn

#endif  // CAIRN_INGEST_SFM_TRIANGULATE_H_
