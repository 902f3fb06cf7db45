#include "engine/pose/pose_estimator.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "engine/pose/solvers/gravity_two_point.h"
#include "engine/pose/solvers/p3p.h"

namespace cairn {
namespace {

// Pixels per radian about a viewing ray: the geometric mean of the two principal scales.
double LocalScalePx(const Camera& camera, const Eigen::Vector3d& ray_in_cam) {
  Eigen::Matrix<double, 2, 3> jacobian;
  if (!camera.ProjectWithJacobian(ray_in_cam, &jacobian)) {
    return camera.focal_px();
  }
  const double determinant = (jacobian * jacobian.transpose()).determinant();
  return determinant > 0.0 ? std::pow(determinant, 0.25) : camera.focal_px();
}

// The observations of `subset`, grouped by keypoint, keypoints in random order.
std::vector<RayObservation> MakeObservations(const QueryContext& query,
                                             const std::vector<Correspondence>& correspondences,
                                             const std::vector<int>& subset,
                                             const PoseOptions& options, uint64_t seed) {
  // Rank of each keypoint in a random permutation (Fisher-Yates).
  Random random(seed);
  std::vector<int> rank(query.keypoints.size());
  for (int i = 0; i < query.num_keypoints(); ++i) {
    const int j = random.Index(i + 1);
    rank[i] = rank[j];
    rank[j] = i;
  }
  std::vector<int> order;
  for (int index : subset) {
    if (!query.rays_in_cam[correspondences[index].keypoint_idx].isZero()) {
      order.push_back(index);
    }
  }
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return std::pair(rank[correspondences[a].keypoint_idx], a) <
           std::pair(rank[correspondences[b].keypoint_idx], b);
  });

  const double max_error_px = options.MaxErrorPx(query.camera.focal_px());
  std::vector<RayObservation> observations;
  observations.reserve(order.size());
  for (int index : order) {
    const Correspondence& correspondence = correspondences[index];
    RayObservation observation;
    observation.ray_in_cam = query.rays_in_cam[correspondence.keypoint_idx];
    observation.x_in_anchor = correspondence.x_in_anchor;
    observation.sigma_m = correspondence.sigma_m;
    observation.keypoint_idx = correspondence.keypoint_idx;
    const bool same_keypoint =
        !observations.empty() && observations.back().keypoint_idx == observation.keypoint_idx;
    observation.threshold_rad =
        same_keypoint ? observations.back().threshold_rad
                      : max_error_px / LocalScalePx(query.camera, observation.ray_in_cam);
    observations.push_back(observation);
  }
  return observations;
}

PoseEstimator::Model ModelFromLevelPose(const LevelPose& pose,
                                        const Eigen::Matrix3d& level_from_cam) {
  // The columns of cam_from_level, turned by yaw about the third.
  const double c = pose.yaw_direction.x(), s = pose.yaw_direction.y();
  const Eigen::Vector3d x = level_from_cam.row(0), y = level_from_cam.row(1);
  PoseEstimator::Model cam_from_anchor;
  cam_from_anchor.col(0) = c * x - s * y;
  cam_from_anchor.col(1) = s * x + c * y;
  cam_from_anchor.col(2) = level_from_cam.row(2);
  cam_from_anchor.col(3) = -cam_from_anchor.leftCols<3>() * pose.center_in_anchor;
  return cam_from_anchor;
}

Rigid3d ToRigid(const PoseEstimator::Model& cam_from_anchor) {
  return {Eigen::Matrix3d(cam_from_anchor.leftCols<3>()), cam_from_anchor.col(3)};
}

}  // namespace

std::optional<GravityPrior> MakeGravityPrior(const QueryContext& query,
                                             const PoseOptions& options) {
  if (!query.down_in_cam) {
    return std::nullopt;
  }
  return GravityPrior{*query.down_in_cam, options.gravity_sigma_rad};
}

PoseEstimator::PoseEstimator(const QueryContext& query,
                             const std::vector<Correspondence>& correspondences,
                             const std::vector<int>& subset, const PoseOptions& options,
                             uint64_t seed)
    : query_(query),
      options_(options),
      observations_(MakeObservations(query, correspondences, subset, options, seed)),
      consensus_(observations_, options.consensus),
      gravity_(MakeGravityPrior(query, options)) {
  if (query.level_from_cam && options.solver != MinimalSolver::kP3p) {
    level_from_cam_ = query.level_from_cam->toRotationMatrix();
    minimal_extra_sq_rad_ = std::pow(2.0 * options.gravity_sigma_rad, 2);
    rays_in_level_.reserve(observations_.size());
    for (const RayObservation& observation : observations_) {
      rays_in_level_.push_back(*level_from_cam_ * observation.ray_in_cam);
    }
  }
}

int PoseEstimator::SampleModels(Random* random, std::array<Model, kMaxModels>* models) {
  std::array<int, 3> keypoints, sample;
  std::array<Eigen::Vector3d, 3> x_in_anchor;
  for (int i = 0; i < sample_size(); ++i) {
    do {
      keypoints[i] = random->Index(num_keypoints());
    } while (std::find(keypoints.begin(), keypoints.begin() + i, keypoints[i]) !=
             keypoints.begin() + i);
    const int begin = consensus_.keypoint_begin(keypoints[i]);
    const int size = consensus_.keypoint_begin(keypoints[i] + 1) - begin;
    sample[i] = begin + random->Index(size);
    x_in_anchor[i] = observations_[sample[i]].x_in_anchor;
  }
  if (level_from_cam_) {
    std::array<LevelPose, 2> poses;
    const int num_poses =
        SolveGravityTwoPoint({rays_in_level_[sample[0]], rays_in_level_[sample[1]]},
                             {x_in_anchor[0], x_in_anchor[1]}, &poses);
    for (int i = 0; i < num_poses; ++i) {
      (*models)[i] = ModelFromLevelPose(poses[i], *level_from_cam_);
    }
    return num_poses;
  }
  return SolveP3p({observations_[sample[0]].ray_in_cam, observations_[sample[1]].ray_in_cam,
                   observations_[sample[2]].ray_in_cam},
                  x_in_anchor, models);
}

double PoseEstimator::ScoreMinimal(const Model& cam_from_anchor, double score_to_beat) {
  return consensus_.Gain(cam_from_anchor, minimal_extra_sq_rad_, score_to_beat);
}

std::vector<PoseObservation> PoseEstimator::LocalInliers(const Model& cam_from_anchor,
                                                         double extra_sq_rad) {
  // More inliers than this make a local optimisation slower, not better. Keypoints stand in random
  // order, so the first ones are a random subset.
  constexpr size_t kMaxInliers = 100;
  std::vector<PoseObservation> inliers;
  for (int index : consensus_.BestObservations(cam_from_anchor, extra_sq_rad)) {
    if (index >= 0 && inliers.size() < kMaxInliers) {
      const RayObservation& observation = observations_[index];
      const Keypoint& keypoint = query_.keypoints[observation.keypoint_idx];
      inliers.push_back(
          {{keypoint.x_px, keypoint.y_px}, observation.x_in_anchor, observation.sigma_m});
    }
  }
  return inliers;
}

std::optional<std::pair<PoseEstimator::Model, double>> PoseEstimator::Optimize(
    const Model& cam_from_anchor) {
  RefinePoseOptions refine_options;
  refine_options.keypoint_sigma_px = options_.keypoint_sigma_px;
  refine_options.max_iterations = 5;
  Model model = cam_from_anchor;
  double extra_sq_rad = minimal_extra_sq_rad_;
  for (int i = 0; i < options_.num_local_optimizations; ++i) {
    const std::vector<PoseObservation> inliers = LocalInliers(model, extra_sq_rad);
    if (static_cast<int>(inliers.size()) <= sample_size()) {
      return std::nullopt;
    }
    model = RefinePose(query_.camera, inliers, gravity_, ToRigid(model), refine_options)
                .cam_from_anchor.ToMatrix();
    extra_sq_rad = 0.0;
  }
  return std::pair(model, consensus_.Gain(model, 0.0, -1.0));
}

double PoseEstimator::SampleProbabilityOfScore(double score) const {
  // A gain is at most 1: there are at least as many inliers. Their keypoints are taken to have as
  // many observations as others.
  const double num_inliers = std::min(score, static_cast<double>(num_keypoints()));
  return std::pow(num_inliers / std::max(1, consensus_.size()), sample_size());
}

double PoseEstimator::InlierSampleProbability(const Model& cam_from_anchor) {
  // A keypoint is drawn first, then one of its observations.
  double sum = 0.0;
  const std::vector<int>& best = consensus_.BestObservations(cam_from_anchor, 0.0);
  for (int k = 0; k < num_keypoints(); ++k) {
    if (best[k] >= 0) {
      sum += 1.0 / (consensus_.keypoint_begin(k + 1) - consensus_.keypoint_begin(k));
    }
  }
  return std::pow(sum / std::max(1, num_keypoints()), sample_size());
}

}  // namespace cairn
