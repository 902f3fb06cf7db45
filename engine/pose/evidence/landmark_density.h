// Where the landmarks of a query's matches fall in an image under a pose, whichever keypoints they
// were matched to: what a keypoint may meet by chance.
#ifndef CAIRN_ENGINE_POSE_EVIDENCE_LANDMARK_DENSITY_H_
#define CAIRN_ENGINE_POSE_EVIDENCE_LANDMARK_DENSITY_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/rigid3.h"
#include "engine/query/query_context.h"

namespace cairn {

// A smoothed histogram of 16 x 16 cells. Landmarks that a pose sees crowded in a small part of the
// image have a high density there.
class LandmarkDensity {
 public:
  // Of the landmarks of at most 1,000 of the correspondences, taken evenly. `camera_idx` is 0 for
  // the query's own camera, i for other_cameras[i - 1].
  LandmarkDensity(const QueryContext& query, const std::vector<Correspondence>& correspondences,
                  const Rigid3d& cam_from_anchor, int camera_idx);

  // The share of the landmarks that fall into a square pixel there; positive.
  double At(const Eigen::Vector2d& pixel) const;

 private:
  static constexpr int kSide = 16;
  int CellOf(const Eigen::Vector2d& pixel) const;

  Eigen::Array2d cell_size_px_;
  std::array<double, kSide * kSide> per_sq_px_{};
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_EVIDENCE_LANDMARK_DENSITY_H_
