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
  int num_iterations = 0;  // Of RANSAC.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_POSE_CANDIDATE_H_
