// Effective inlier count (Irschara, Zach, Frahm, Bischof, "From structure-from-motion point clouds
// to fast location recognition", CVPR 2009): inliers that crowd in one spot of the image say less
// about the pose than inliers spread over all of it.
#ifndef CAIRN_ENGINE_POSE_EVIDENCE_EFFECTIVE_INLIERS_H_
#define CAIRN_ENGINE_POSE_EVIDENCE_EFFECTIVE_INLIERS_H_

#include <Eigen/Core>
#include <vector>

namespace cairn {

// Each inlier covers a disc whose radius is 1/32 of the image's diagonal. The result is
//   number of inliers * area of the union of the discs / sum of their areas,
// where areas are counted in cells of a grid of 128 x 128 over the full image, and what lies
// outside counts nowhere. n inliers far from each other give n, n at one pixel give 1; an image
// cannot give more than about 200 (4:3). Pixels outside the image are moved to its border.
double EffectiveInliers(const std::vector<Eigen::Vector2d>& pixels, int width_px, int height_px);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_EVIDENCE_EFFECTIVE_INLIERS_H_
