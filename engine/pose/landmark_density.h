// The density, in an image under a pose, of the landmarks of a query's matches. The landmarks count
// regardless of the keypoints they were matched to. The density gives the chance that a keypoint
// meets one of them.
#ifndef CAIRN_ENGINE_POSE_LANDMARK_DENSITY_H_
#define CAIRN_ENGINE_POSE_LANDMARK_DENSITY_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/rigid3.h"
#include "engine/query/query_context.h"

namespace cairn {

// A smoothed histogram of 16 x 16 cells. Where a pose crowds landmarks in a small part of the
// image, the density there is high.
class LandmarkDensity {
 public:
  // Uses the landmarks of at most 1,000 correspondences, at even intervals, but not of those that
  // were sought given a pose. `camera_idx` is 0 for the query's own camera, i for other_cameras[i -
  // 1].
  LandmarkDensity(const QueryContext& query, const std::vector<Correspondence>& correspondences,
                  const Rigid3d& cam_from_anchor, int camera_idx);

  // Returns the share of the landmarks that fall into a square pixel at `pixel`; positive.
  double At(const Eigen::Vector2d& pixel) const;

 private:
  static constexpr int kSide = 16;
  int CellOf(const Eigen::Vector2d& pixel) const;

  Eigen::Array2d cell_size_px_;
  std::array<double, kSide * kSide> per_sq_px_{};
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_LANDMARK_DENSITY_H_
