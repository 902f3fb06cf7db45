// Effective inlier count (Irschara, Zach, Frahm, Bischof, "From structure-from-motion point clouds
// to fast location recognition", CVPR 2009). Inliers that are close together in the image say less
// about the pose than inliers spread over the image.
#ifndef CAIRN_ENGINE_POSE_EFFECTIVE_INLIERS_H_
#define CAIRN_ENGINE_POSE_EFFECTIVE_INLIERS_H_

#include <Eigen/Core>
#include <vector>

namespace cairn {

// Each inlier covers a disc whose radius is 1/32 of the image's diagonal. The result is
//   number of inliers * area of the union of the discs / sum of their areas.
// Areas are counted in cells of a 128 x 128 grid over the image; parts outside the image do not
// count. n inliers far from each other give n; n inliers at one pixel give 1. An image gives at
// most about 200 (4:3). Pixels outside the image are moved to its border.
double EffectiveInliers(const std::vector<Eigen::Vector2d>& pixels, int width_px, int height_px);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_EFFECTIVE_INLIERS_H_
