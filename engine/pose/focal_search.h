// Chooses the focal lengths to try for an uncalibrated camera, and reports what the answer says
// about the stated focal length.
#ifndef CAIRN_ENGINE_POSE_FOCAL_SEARCH_H_
#define CAIRN_ENGINE_POSE_FOCAL_SEARCH_H_

#include <optional>
#include <vector>

#include "engine/pose/refine_camera.h"
#include "engine/query/localize_query.h"
#include "engine/query/localize_result.h"

namespace cairn {

// If a query does not state the uncertainty of its focal length, its relative standard deviation is
// assumed to be this.
inline constexpr double kAssumedFocalLogSigma = 0.01;
// Pose estimation works with a relative error of the focal length up to this. If the error may be
// larger, several focal lengths are tried.
inline constexpr double kMaxTrustedFocalLogSigma = 0.03;

// Returns what a query states about its camera. The query must not be a rig's.
CameraPrior CameraPriorOf(const LocalizeQuery& query);

// Chooses factors of the prior's focal length, up to three standard deviations on either side, so
// close together that RefineWithCamera reaches the focal lengths in between.
//
// The search tries the likeliest factors first until one leads to a good score. A wrong focal
// length may have a fair score, too, so the search then tries the neighbors of the best factor
// until both of its neighbors are worse.
class FocalSearch {
 public:
  FocalSearch(const FocalPrior& prior, double good_score);

  // Returns the next factor to try; nothing if the search is complete.
  std::optional<double> Next();
  // Reports the score of the factor that Next returned last.
  void Report(double score);

 private:
  std::vector<double> factors_;                // Ascending.
  std::vector<std::optional<double>> scores_;  // Parallel to factors_.
  double good_score_;
  int current_ = 0;
};

// Returns the logarithm of the share of the prior's focal lengths that the refined camera stands
// for: the prior's density at its focal length times the width that the inliers leave, as
// LogPoseShare does for poses. The logarithm of the focal length follows a Student distribution
// with three degrees of freedom, because stated focal lengths are sometimes grossly wrong. At most
// 0.
double LogCameraShare(const CameraPrior& prior, const RefinedCamera& refined);

CameraEstimate MakeCameraEstimate(const CameraPrior& prior, const RefinedCamera& refined);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_FOCAL_SEARCH_H_
