// The input of pose estimation, which voting and keyframe ranking produce, and its output.
#ifndef CAIRN_ENGINE_QUERY_POSE_CANDIDATE_H_
#define CAIRN_ENGINE_QUERY_POSE_CANDIDATE_H_

#include <Eigen/Core>
#include <vector>

#include "core/rigid3.h"

namespace cairn {

// A region of pose space with the correspondences that agree with it.
struct PoseCandidate {
  Eigen::Vector3d center_in_anchor = Eigen::Vector3d::Zero();  // Camera center.
  double yaw_rad = 0.0;              // anchor_from_level is the rotation by yaw about z.
  double score = 0.0;                // Weighted number of distinct keypoints.
  std::vector<int> correspondences;  // Indices into the query's correspondences, ascending.
};

// A pose found from correspondences.
struct PoseEstimate {
  Rigid3d cam_from_anchor;
  std::vector<int> inliers;  // Indices into the given correspondences; one per keypoint.
  double consensus = 0.0;    // MSAC gain over the candidate's correspondences; see ConsensusSet.
  double evidence = 0.0;  // That the inliers do not agree by chance; see PoseEvidence::log_ratio.
  std::vector<double> right_probabilities;  // Of the inliers; see PoseEvidence.
  double mean_sq_error_px = 0.0;            // Over the inliers.
  // As LocalizeResult::covariance.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  // Logarithm of the volume of poses that explain the inliers about as well: that of a Gaussian
  // with the covariance of the pose under the query's camera, sqrt(det(2 pi covariance)), rad^3
  // m^3.
  double log_volume = 0.0;
  // Logarithm of the density of tilts that the query's gravity gives at the pose, per rad^2; 0 (a
  // range of one radian about each axis) without gravity.
  double log_tilt_density = 0.0;
  // Logarithm of the share of the camera's prior that explains the inliers about as well; 0 if the
  // camera was not estimated.
  double log_camera_share = 0.0;
  // The inliers doubt the query's camera, which is kept; the covariance includes the doubt.
  bool doubts_camera = false;
  int num_iterations = 0;  // Of RANSAC.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_POSE_CANDIDATE_H_
