// Scores poses against many correspondences at once.
#ifndef CAIRN_ENGINE_POSE_CONSENSUS_H_
#define CAIRN_ENGINE_POSE_CONSENSUS_H_

#include <Eigen/Core>
#include <vector>

#include "engine/pose/pose_options.h"
#include "engine/pose/sequential_test.h"

namespace cairn {

// A correspondence in the form that scoring needs. The error of a pose is the angle between the
// observed ray and the direction to the landmark. This angle equals the reprojection error in the
// distorted image divided by the local scale of the projection, and is valid for any field of view.
struct RayObservation {
  Eigen::Vector3d ray_in_cam;  // Unit vector.
  Eigen::Vector3d x_in_anchor;
  double threshold_rad = 0.0;  // An observation with a larger angular error is not an inlier.
  // Of the landmark. Widens the threshold by three times the angle that sigma_m subtends, to at
  // most twice `threshold_rad`.
  double sigma_m = 0.0;
  int keypoint_idx = 0;
  float sq_distance = 0.0f;  // Of the descriptors.
  // Where the ray starts, in the camera frame. Zero except for the other cameras of a rig.
  Eigen::Vector3d origin_in_cam = Eigen::Vector3d::Zero();
};

// A set of observations, which computes the MSAC gain of poses. For an observation with angular
// error e and threshold t (widened as above), the gain is max(0, 1 - (sin e / t)^2) in front of the
// camera and 0 behind it. The gain is the complement of the truncated quadratic cost. For each
// keypoint, only the best observation counts.
//
// Observations are stored as float arrays relative to their mean, so that eight or sixteen are
// scored at a time and a far origin costs no precision. Not thread-safe, not even const methods,
// which share a scratch buffer. Use one object per query.
class ConsensusSet {
 public:
  // Observations of a keypoint must be adjacent. Early rejection works only if the keypoints are in
  // random order.
  explicit ConsensusSet(const std::vector<RayObservation>& observations,
                        const ConsensusOptions& options = {});

  int size() const { return size_; }
  int num_keypoints() const { return static_cast<int>(keypoint_begin_.size()) - 1; }
  // The observations [keypoint_begin(i), keypoint_begin(i + 1)) belong to the i-th keypoint.
  int keypoint_begin(int i) const { return keypoint_begin_[i]; }

  // Returns the sum of the gains over the keypoints for a pose cam_from_anchor = [R | t], with
  // every squared threshold enlarged by `extra_sq_rad`. With early rejection, stops and returns 0
  // once the gain certainly or very likely stays below `gain_to_beat` (see SequentialTest, in steps
  // of 64 observations).
  double Gain(const Eigen::Matrix<double, 3, 4>& cam_from_anchor, double extra_sq_rad,
              double gain_to_beat);

  // Returns the index of each keypoint's best observation, or -1 if none is an inlier.
  const std::vector<int>& BestObservations(const Eigen::Matrix<double, 3, 4>& cam_from_anchor,
                                           double extra_sq_rad);

 private:
  // Fills gains_. Returns false without filling all of them if the pose certainly or very likely
  // does not beat `gain_to_beat`.
  bool FillGains(const Eigen::Matrix<double, 3, 4>& cam_from_anchor, double extra_sq_rad,
                 double gain_to_beat);

  ConsensusOptions options_;
  int size_ = 0;
  Eigen::Vector3d origin_in_anchor_ = Eigen::Vector3d::Zero();
  // Each array is padded to a multiple of the block size with observations that are never inliers.
  std::vector<float> ray_x_, ray_y_, ray_z_;
  std::vector<float> point_x_, point_y_, point_z_;  // Relative to origin_in_anchor_.
  std::vector<float> sq_threshold_, sq_sigma_;
  // Origins of the rays; empty if all are zero.
  std::vector<float> origin_x_, origin_y_, origin_z_;
  std::vector<int> keypoint_begin_;
  SequentialTest test_;
  // Scratch.
  std::vector<float> gains_;
  std::vector<int> best_observations_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_CONSENSUS_H_
