// Chooses the focal lengths to try for an uncalibrated camera, and reports what the answer says
// about the stated focal length.
#ifndef CAIRN_ENGINE_POSE_FOCAL_SEARCH_H_
#define CAIRN_ENGINE_POSE_FOCAL_SEARCH_H_

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

// Returns what a query states about its camera. The principal point is known unless the focal
// length is uncertain and the principal point is exactly in the middle. The query must not be a
// rig's.
CameraPrior CameraPriorOf(const LocalizeQuery& query);

// Returns the prior of a photo that was cut out of another, not around its middle. The optical axis
// may be anywhere, and the photo's size says little about the focal length.
CameraPrior OffCenterPrior(CameraPrior prior);

// Returns factors of the prior's focal length to try, likeliest first: up to three standard
// deviations on either side, so close together that RefineWithCamera reaches the focal lengths in
// between. Only 1 if the prior is certain (kMaxTrustedFocalLogSigma).
//
// All of them are to be tried. A wrong focal length has its own best pose, which trades the focal
// length for the distance and may explain hundreds of keypoints. RefineWithCamera does not leave
// such a pose, and guesses on both of its sides may lead to it, so neither says that the search has
// passed the right one.
std::vector<double> FocalGuesses(const FocalPrior& prior);

// Returns the logarithm of the share of the prior's focal lengths that the refined camera stands
// for: the prior's density at its focal length times the width that the inliers leave, as
// LogPoseShare does for poses. The logarithm of the focal length follows a Student distribution
// with three degrees of freedom, because stated focal lengths are sometimes grossly wrong, and so
// do the coordinates of the principal point. At most 0.
double LogCameraShare(const CameraPrior& prior, const RefinedCamera& refined);

// `prior` is that of the query, also if the photo is off center.
CameraEstimate MakeCameraEstimate(const CameraPrior& prior, const RefinedCamera& refined);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_FOCAL_SEARCH_H_
