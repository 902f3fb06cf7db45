// Camera pose estimation as a problem for LoRansac.
#ifndef CAIRN_ENGINE_POSE_POSE_RANSAC_PROBLEM_H_
#define CAIRN_ENGINE_POSE_POSE_RANSAC_PROBLEM_H_

#include <Eigen/Core>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "core/random.h"
#include "core/rigid3.h"
#include "engine/pose/alias_table.h"
#include "engine/pose/consensus.h"
#include "engine/pose/pose_options.h"
#include "engine/pose/refine_pose.h"
#include "engine/query/query_context.h"

namespace cairn {

// Computes poses from gravity two-point or P3P samples (see MinimalSolver). Two-point samples need
// gravity. See LoRansac for the contract of the methods.
//
// In a rig, the two points may belong to different cameras. The three points of P3P belong to one
// camera, so cameras with fewer keypoints give no samples.
//
// Most samples of wrong matches contradict themselves: the camera would be too near or too far for
// the sizes of the sample's own keypoints. Such poses are dropped before they are scored, which is
// what costs most.
//
// A two-point pose inherits the error of the measured gravity, so it is scored with thresholds
// widened by twice gravity_sigma_rad. Local optimization frees all six degrees of freedom and
// scores with unwidened thresholds. Keeps references to its arguments. Not thread-safe.
class PoseRansacProblem {
 public:
  using Model = Eigen::Matrix<double, 3, 4>;  // cam_from_anchor = [R | t].
  static constexpr int kMaxModels = 4;

  // Samples and scores the correspondences `subset`. `seed` determines the order of scoring.
  PoseRansacProblem(const QueryContext& query, const std::vector<Correspondence>& correspondences,
                    const std::vector<int>& subset, const PoseOptions& options, uint64_t seed);

  // Number of distinct keypoints that have a ray.
  int num_keypoints() const { return consensus_.num_keypoints(); }
  // Number of keypoints of a minimal sample.
  int sample_size() const { return level_from_cam_ ? 2 : 3; }

  int SampleModels(Random* random, std::array<Model, kMaxModels>* models);
  double ScoreMinimal(const Model& cam_from_anchor, double score_to_beat);
  std::optional<std::pair<Model, double>> Optimize(const Model& cam_from_anchor);
  double InlierSampleProbability(const Model& cam_from_anchor);
  double SampleProbabilityOfScore(double score) const;

 private:
  // Draws observations of distinct keypoints. Returns false if the camera of the first has too few
  // for P3P.
  bool DrawSample(Random* random, std::array<int, 3>* sample) const;
  // Returns the number of poses that explain a sample.
  int SolveSample(const std::array<int, 3>& sample, std::array<Model, kMaxModels>* models) const;
  // Returns true if the sizes of the sample's keypoints fit the pose.
  bool HasPlausibleSizes(const std::array<int, 3>& sample, const Model& cam_from_anchor) const;
  std::vector<PoseObservation> LocalInliers(const Model& cam_from_anchor, double extra_sq_rad);

  const QueryContext& query_;
  const std::vector<Correspondence>& correspondences_;
  const PoseOptions& options_;
  std::vector<int> order_;                    // The correspondence of each observation.
  std::vector<RayObservation> observations_;  // Keypoints in random order.
  ConsensusSet consensus_;
  // Preference for an observation over others of its keypoint, in (0, 1]; 1 for the observation
  // with the smallest descriptor distance of all.
  std::vector<double> preference_;
  AliasTable draw_;  // Over all observations.
  // Only for two-point samples.
  std::optional<Eigen::Matrix3d> level_from_cam_;
  std::vector<Eigen::Vector3d> rays_in_level_;  // Per observation.
  std::vector<Eigen::Vector3d> origins_in_level_;
  // Only for P3P in a rig.
  struct CameraDraw {
    int num_keypoints = 0;
    AliasTable draw;  // Over the camera's observations.
  };
  std::vector<CameraDraw> camera_draws_;
  std::optional<GravityPrior> gravity_;
  double minimal_extra_sq_rad_ = 0.0;
};

// Returns the gravity prior of a query; nothing if the query has no gravity.
std::optional<GravityPrior> MakeGravityPrior(const QueryContext& query, const PoseOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_POSE_RANSAC_PROBLEM_H_
