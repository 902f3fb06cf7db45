// Scores poses against many correspondences at once.
#ifndef CAIRN_ENGINE_POSE_CONSENSUS_H_
#define CAIRN_ENGINE_POSE_CONSENSUS_H_

#include <Eigen/Core>
#include <vector>

#include "engine/pose/pose_options.h"
#include "engine/pose/sampling/sequential_test.h"

namespace cairn {

// A correspondence in the form it is scored: the error of a pose is the angle between the observed
// ray and the direction to the landmark, which is the reprojection error of the distorted image
// over the local scale of the projection, and holds for any field of view.
struct RayObservation {
  Eigen::Vector3d ray_in_cam;  // Unit vector.
  Eigen::Vector3d x_in_anchor;
  double threshold_rad = 0.0;  // Angular error at which it stops to be an inlier.
  double sigma_m = 0.0;        // Of the landmark; widens the threshold by three times the angle it
                               // subtends, to at most twice `threshold_rad`.
  int keypoint_idx = 0;
  float sq_distance = 0.0f;  // Of the descriptors.
  // Where the ray starts, in the camera frame: not zero for the further cameras of a rig.
  Eigen::Vector3d origin_in_cam = Eigen::Vector3d::Zero();
};

// A set of observations and the MSAC gain of poses on it. The gain of an observation with angular
// error e and threshold t (widened as above) is max(0, 1 - (sin e / t)^2) in front of the camera, 0
// behind it; it is the complement of the truncated quadratic cost. Of the observations of one
// keypoint only the best counts.
//
// Observations are kept as arrays of floats about their mean, so that eight or sixteen are scored
// at a time and far origins cost no precision. Const calls are not thread-safe: they share a
// scratch buffer. One object serves one query.
class ConsensusSet {
 public:
  // Observations of a keypoint must be adjacent. For early rejection to work the keypoints should
  // stand in random order.
  explicit ConsensusSet(const std::vector<RayObservation>& observations,
                        const ConsensusOptions& options = {});

  int size() const { return size_; }
  int num_keypoints() const { return static_cast<int>(keypoint_begin_.size()) - 1; }
  // Observations [keypoint_begin(i), keypoint_begin(i + 1)) are those of the i-th keypoint.
  int keypoint_begin(int i) const { return keypoint_begin_[i]; }

  // Sum of the gains over the keypoints for a pose cam_from_anchor = [R | t], with every squared
  // threshold enlarged by `extra_sq_rad`. With early rejection it gives up, returning 0, when the
  // gain provably or very likely stays below `gain_to_beat` (see SequentialTest, in steps of 64
  // observations).
  double Gain(const Eigen::Matrix<double, 3, 4>& cam_from_anchor, double extra_sq_rad,
              double gain_to_beat);

  // For each keypoint the index of its best observation, or -1 if none is an inlier.
  const std::vector<int>& BestObservations(const Eigen::Matrix<double, 3, 4>& cam_from_anchor,
                                           double extra_sq_rad);

 private:
  // Writes gains_, all of them unless it returns false because the pose cannot, or very likely will
  // not, beat `gain_to_beat`.
  bool FillGains(const Eigen::Matrix<double, 3, 4>& cam_from_anchor, double extra_sq_rad,
                 double gain_to_beat);

  ConsensusOptions options_;
  int size_ = 0;
  Eigen::Vector3d origin_in_anchor_ = Eigen::Vector3d::Zero();
  // Each padded to a multiple of the block with observations that are never inliers.
  std::vector<float> ray_x_, ray_y_, ray_z_;
  std::vector<float> point_x_, point_y_, point_z_;  // About the origin.
  std::vector<float> sq_threshold_, sq_sigma_;
  std::vector<float> origin_x_, origin_y_, origin_z_;  // Of the rays; empty if all are zero.
  std::vector<int> keypoint_begin_;
  SequentialTest test_;
  // Scratch.
  std::vector<float> gains_;
  std::vector<int> best_observations_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_CONSENSUS_H_
