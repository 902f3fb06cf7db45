#include "engine/pose/pose_ransac_problem.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/keypoint_shape.h"
#include "engine/pose/gravity_two_point.h"
#include "engine/pose/p3p.h"

namespace cairn {
namespace {

// Returns the pixels per radian at a viewing ray: the geometric mean of the two principal scales.
double LocalScalePx(const Camera& camera, const Eigen::Vector3d& ray_in_cam) {
  Eigen::Matrix<double, 2, 3> jacobian;
  if (!camera.ProjectWithJacobian(ray_in_cam, &jacobian)) {
    return camera.focal_px();
  }
  const double determinant = (jacobian * jacobian.transpose()).determinant();
  return determinant > 0.0 ? std::sqrt(std::sqrt(determinant)) : camera.focal_px();
}

// Returns the angular error beyond which an observation is not an inlier.
double ThresholdRad(const QueryContext& query, const RayObservation& observation,
                    const PoseOptions& options) {
  const Camera& camera = query.CameraOf(observation.keypoint_idx);
  const Eigen::Vector3d on_ray = observation.origin_in_cam + observation.ray_in_cam;
  return options.MaxErrorPx(camera.focal_px()) /
         LocalScalePx(camera, query.InCameraOf(observation.keypoint_idx, on_ray));
}

// Returns the correspondences of `subset` whose keypoint has a ray, ordered by the keypoint's rank,
// then by index. A counting sort.
std::vector<int> OrderByRank(const QueryContext& query,
                             const std::vector<Correspondence>& correspondences,
                             const std::vector<int>& subset, const std::vector<int>& rank) {
  const auto keypoint_of = [&](int index) { return correspondences[index].keypoint_idx; };
  const auto has_ray = [&](int index) { return !query.rays_in_cam[keypoint_of(index)].isZero(); };
  std::vector<int> begin(rank.size() + 1, 0);
  for (const int index : subset) {
    begin[rank[keypoint_of(index)] + 1] += has_ray(index) ? 1 : 0;
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<int> order(begin.back());
  for (const int index : subset) {
    if (has_ray(index)) {
      order[begin[rank[keypoint_of(index)]]++] = index;
    }
  }
  // If `subset` is sorted, the indices already ascend.
  if (!std::is_sorted(subset.begin(), subset.end())) {
    for (size_t i = 0, first = 0; i < order.size(); first = i) {
      while (i < order.size() && keypoint_of(order[i]) == keypoint_of(order[first])) {
        ++i;
      }
      std::sort(order.begin() + static_cast<ptrdiff_t>(first),
                order.begin() + static_cast<ptrdiff_t>(i));
    }
  }
  return order;
}

// Returns `subset`, grouped by keypoint, with the keypoints in random order, without keypoints that
// have no ray.
std::vector<int> OrderAtRandom(const QueryContext& query,
                               const std::vector<Correspondence>& correspondences,
                               const std::vector<int>& subset, uint64_t seed) {
  // Rank of each keypoint in a random permutation (Fisher-Yates).
  Random random(seed);
  std::vector<int> rank(query.keypoints.size());
  for (int i = 0; i < query.num_keypoints(); ++i) {
    const int j = random.Index(i + 1);
    rank[i] = rank[j];
    rank[j] = i;
  }
  return OrderByRank(query, correspondences, subset, rank);
}

std::vector<RayObservation> MakeObservations(const QueryContext& query,
                                             const std::vector<Correspondence>& correspondences,
                                             const std::vector<int>& order,
                                             const PoseOptions& options) {
  std::vector<RayObservation> observations;
  observations.reserve(order.size());
  for (const int index : order) {
    const Correspondence& correspondence = correspondences[index];
    RayObservation observation;
    observation.ray_in_cam = query.rays_in_cam[correspondence.keypoint_idx];
    observation.x_in_anchor = correspondence.x_in_anchor;
    observation.sigma_m = correspondence.sigma_m;
    observation.keypoint_idx = correspondence.keypoint_idx;
    observation.sq_distance = correspondence.sq_distance;
    observation.origin_in_cam = query.OriginInCam(correspondence.keypoint_idx);
    const bool same_keypoint =
        !observations.empty() && observations.back().keypoint_idx == observation.keypoint_idx;
    observation.threshold_rad = same_keypoint ? observations.back().threshold_rad
                                              : ThresholdRad(query, observation, options);
    observations.push_back(observation);
  }
  return observations;
}

// See preference_. Bounded below, so that every match can be drawn.
std::vector<double> PreferenceOf(const std::vector<RayObservation>& observations,
                                 double same_landmark_distance, double distance_weight) {
  constexpr double kMin = 0.01;
  std::vector<double> preference(observations.size(), 1.0);
  if (observations.empty() || same_landmark_distance <= 0.0) {
    return preference;
  }
  const double scale = distance_weight / (same_landmark_distance * same_landmark_distance);
  const auto nearer = [](const RayObservation& a, const RayObservation& b) {
    return a.sq_distance < b.sq_distance;
  };
  const double least =
      std::min_element(observations.begin(), observations.end(), nearer)->sq_distance;
  for (size_t i = 0; i < observations.size(); ++i) {
    preference[i] = std::max(kMin, std::exp(-scale * (observations[i].sq_distance - least)));
  }
  return preference;
}

// Returns the weight with which each observation is drawn: its preference divided by the number of
// its keypoint's observations.
std::vector<double> DrawWeights(const ConsensusSet& consensus,
                                const std::vector<double>& preference) {
  std::vector<double> weights(preference.size());
  for (int k = 0; k < consensus.num_keypoints(); ++k) {
    const int begin = consensus.keypoint_begin(k), end = consensus.keypoint_begin(k + 1);
    for (int i = begin; i < end; ++i) {
      weights[i] = preference[i] / (end - begin);
    }
  }
  return weights;
}

PoseRansacProblem::Model ModelFromLevelPose(const LevelPose& pose,
                                            const Eigen::Matrix3d& level_from_cam) {
  // The columns of cam_from_level, rotated by the yaw about the third.
  const double c = pose.yaw_direction.x(), s = pose.yaw_direction.y();
  const Eigen::Vector3d x = level_from_cam.row(0), y = level_from_cam.row(1);
  PoseRansacProblem::Model cam_from_anchor;
  cam_from_anchor.col(0) = c * x - s * y;
  cam_from_anchor.col(1) = s * x + c * y;
  cam_from_anchor.col(2) = level_from_cam.row(2);
  cam_from_anchor.col(3) = -cam_from_anchor.leftCols<3>() * pose.center_in_anchor;
  return cam_from_anchor;
}

Rigid3d ToRigid(const PoseRansacProblem::Model& cam_from_anchor) {
  return {Eigen::Matrix3d(cam_from_anchor.leftCols<3>()), cam_from_anchor.col(3)};
}

// Returns false if the keypoint is kMaxSizeFactor times as large as the landmark's size predicts
// from there, or as small. That costs a match 10 nats of evidence (EvidenceModel::size), more than
// it can make up for. A tighter limit loses poses from samples that are nearly right. Nothing
// speaks against a size that is unknown. Poses behind the mapped surface stay: a mirrored session
// gives itself away by them (CompareWithMap).
bool HasPlausibleSize(const QueryContext& query, const Correspondence& match, double sq_distance) {
  constexpr double kMaxSizeFactor = 4.0;
  const Keypoint& keypoint = query.keypoints[match.keypoint_idx];
  if (match.size_m <= 0.0f || !HasScale(keypoint)) {
    return true;
  }
  const double predicted_m =
      match.size_m * query.CameraOf(match.keypoint_idx).focal_px() / keypoint.scale_px;
  const double sq_ratio = sq_distance / (predicted_m * predicted_m);
  constexpr double kMaxSqRatio = kMaxSizeFactor * kMaxSizeFactor;
  return sq_ratio <= kMaxSqRatio && sq_ratio >= 1.0 / kMaxSqRatio;
}

}  // namespace

std::optional<GravityPrior> MakeGravityPrior(const QueryContext& query,
                                             const PoseOptions& options) {
  if (!query.down_in_cam) {
    return std::nullopt;
  }
  return GravityPrior{*query.down_in_cam, options.gravity_sigma_rad};
}

PoseRansacProblem::PoseRansacProblem(const QueryContext& query,
                                     const std::vector<Correspondence>& correspondences,
                                     const std::vector<int>& subset, const PoseOptions& options,
                                     uint64_t seed)
    : query_(query),
      correspondences_(correspondences),
      options_(options),
      order_(OrderAtRandom(query, correspondences, subset, seed)),
      observations_(MakeObservations(query, correspondences, order_, options)),
      consensus_(observations_, options.consensus),
      preference_(
          PreferenceOf(observations_, query.same_landmark_distance, options.distance_weight)),
      draw_(DrawWeights(consensus_, preference_)),
      gravity_(MakeGravityPrior(query, options)) {
  if (query.level_from_cam && options.solver != MinimalSolver::kP3p) {
    level_from_cam_ = query.level_from_cam->toRotationMatrix();
    minimal_extra_sq_rad_ = std::pow(2.0 * options.gravity_sigma_rad, 2);
    rays_in_level_.reserve(observations_.size());
    origins_in_level_.reserve(observations_.size());
    for (const RayObservation& observation : observations_) {
      rays_in_level_.push_back(*level_from_cam_ * observation.ray_in_cam);
      origins_in_level_.push_back(*level_from_cam_ * observation.origin_in_cam);
    }
  } else if (query.is_rig()) {
    const std::vector<double> weights = DrawWeights(consensus_, preference_);
    for (int camera = 0; camera < query.num_cameras(); ++camera) {
      std::vector<double> of_camera = weights;
      for (size_t i = 0; i < of_camera.size(); ++i) {
        of_camera[i] *= query.CameraIdxOf(observations_[i].keypoint_idx) == camera ? 1.0 : 0.0;
      }
      camera_draws_.push_back({0, AliasTable(of_camera)});
    }
    for (int k = 0; k < num_keypoints(); ++k) {
      const int keypoint_idx = observations_[consensus_.keypoint_begin(k)].keypoint_idx;
      ++camera_draws_[query.CameraIdxOf(keypoint_idx)].num_keypoints;
    }
  }
}

bool PoseRansacProblem::DrawSample(Random* random, std::array<int, 3>* sample) const {
  const AliasTable* draw = &draw_;  // In a rig, the camera of the first draw replaces this.
  const auto keypoint_of = [this](int index) { return observations_[index].keypoint_idx; };
  for (int i = 0; i < sample_size(); ++i) {
    int& drawn = (*sample)[i];
    do {
      drawn = draw->Draw(random);
    } while (std::any_of(sample->begin(), sample->begin() + i,
                         [&](int other) { return keypoint_of(other) == keypoint_of(drawn); }));
    if (i == 0 && !camera_draws_.empty()) {
      const CameraDraw& of_camera = camera_draws_[query_.CameraIdxOf(keypoint_of(drawn))];
      if (of_camera.num_keypoints < sample_size()) {
        return false;
      }
      draw = &of_camera.draw;
    }
  }
  return true;
}

int PoseRansacProblem::SolveSample(const std::array<int, 3>& sample,
                                   std::array<Model, kMaxModels>* models) const {
  std::array<Eigen::Vector3d, 3> x_in_anchor;
  for (int i = 0; i < sample_size(); ++i) {
    x_in_anchor[i] = observations_[sample[i]].x_in_anchor;
  }
  if (level_from_cam_) {
    std::array<LevelPose, 2> poses;
    const int num_poses = SolveGravityTwoPoint(
        {rays_in_level_[sample[0]], rays_in_level_[sample[1]]}, {x_in_anchor[0], x_in_anchor[1]},
        &poses, {origins_in_level_[sample[0]], origins_in_level_[sample[1]]});
    for (int i = 0; i < num_poses; ++i) {
      (*models)[i] = ModelFromLevelPose(poses[i], *level_from_cam_);
    }
    return num_poses;
  }
  const int num_poses =
      SolveP3p({observations_[sample[0]].ray_in_cam, observations_[sample[1]].ray_in_cam,
                observations_[sample[2]].ray_in_cam},
               x_in_anchor, models);
  for (int i = 0; i < num_poses; ++i) {
    (*models)[i].col(3) += observations_[sample[0]].origin_in_cam;
  }
  return num_poses;
}

bool PoseRansacProblem::HasPlausibleSizes(const std::array<int, 3>& sample,
                                          const Model& cam_from_anchor) const {
  return std::all_of(sample.begin(), sample.begin() + sample_size(), [&](int index) {
    const RayObservation& observation = observations_[index];
    const Eigen::Vector3d camera_in_anchor = cam_from_anchor.leftCols<3>().transpose() *
                                             (observation.origin_in_cam - cam_from_anchor.col(3));
    return HasPlausibleSize(query_, correspondences_[order_[index]],
                            (camera_in_anchor - observation.x_in_anchor).squaredNorm());
  });
}

int PoseRansacProblem::SampleModels(Random* random, std::array<Model, kMaxModels>* models) {
  std::array<int, 3> sample;
  if (!DrawSample(random, &sample)) {
    return 0;
  }
  const auto end = models->begin() + SolveSample(sample, models);
  return static_cast<int>(
      std::remove_if(models->begin(), end,
                     [&](const Model& model) { return !HasPlausibleSizes(sample, model); }) -
      models->begin());
}

double PoseRansacProblem::ScoreMinimal(const Model& cam_from_anchor, double score_to_beat) {
  return consensus_.Gain(cam_from_anchor, minimal_extra_sq_rad_, score_to_beat);
}

std::vector<PoseObservation> PoseRansacProblem::LocalInliers(const Model& cam_from_anchor,
                                                             double extra_sq_rad) {
  // More inliers make a local optimization slower, not better. Keypoints are in random order, so
  // the first ones are a random subset.
  constexpr size_t kMaxInliers = 100;
  std::vector<PoseObservation> inliers;
  for (int index : consensus_.BestObservations(cam_from_anchor, extra_sq_rad)) {
    if (index >= 0 && inliers.size() < kMaxInliers) {
      const RayObservation& observation = observations_[index];
      const Keypoint& keypoint = query_.keypoints[observation.keypoint_idx];
      inliers.push_back({{keypoint.x_px, keypoint.y_px},
                         observation.x_in_anchor,
                         observation.sigma_m,
                         query_.CameraIdxOf(observation.keypoint_idx)});
    }
  }
  return inliers;
}

std::optional<std::pair<PoseRansacProblem::Model, double>> PoseRansacProblem::Optimize(
    const Model& cam_from_anchor) {
  RefinePoseOptions refine_options;
  refine_options.keypoint_sigma_px = options_.keypoint_sigma_px;
  refine_options.max_iterations = 5;
  refine_options.min_relative_decrease = 1e-3;  // The best pose is refined to convergence later.
  constexpr int kNumRefinements = 2;            // Each time a minimal model improves the score.
  Model model = cam_from_anchor;
  double extra_sq_rad = minimal_extra_sq_rad_;
  for (int i = 0; i < kNumRefinements; ++i) {
    const std::vector<PoseObservation> inliers = LocalInliers(model, extra_sq_rad);
    if (static_cast<int>(inliers.size()) <= sample_size()) {
      return std::nullopt;
    }
    model = RefinePose(query_.camera, inliers, gravity_, ToRigid(model), refine_options,
                       query_.other_cameras)
                .cam_from_anchor.ToMatrix();
    extra_sq_rad = 0.0;
  }
  return std::pair(model, consensus_.Gain(model, 0.0, -1.0));
}

double PoseRansacProblem::SampleProbabilityOfScore(double score) const {
  // A gain is at most 1, so there are at least `score` inliers. Their keypoints are assumed to have
  // as many observations as other keypoints, and to be drawn as often.
  const double num_inliers = std::min(score, static_cast<double>(num_keypoints()));
  return std::pow(num_inliers / std::max(1, consensus_.size()), sample_size());
}

double PoseRansacProblem::InlierSampleProbability(const Model& cam_from_anchor) {
  struct Draws {  // Sums of draw weights.
    double all = 0.0;
    double inliers = 0.0;
    int num_keypoints = 0;
  };
  const bool by_camera = !camera_draws_.empty();
  std::vector<Draws> cameras(by_camera ? camera_draws_.size() : 1);
  const std::vector<int>& best = consensus_.BestObservations(cam_from_anchor, 0.0);
  double all = 0.0;
  for (int k = 0; k < num_keypoints(); ++k) {
    const int begin = consensus_.keypoint_begin(k), end = consensus_.keypoint_begin(k + 1);
    Draws& draws = cameras[by_camera ? query_.CameraIdxOf(observations_[begin].keypoint_idx) : 0];
    const double of_keypoint =
        std::accumulate(preference_.begin() + begin, preference_.begin() + end, 0.0) /
        (end - begin);
    all += of_keypoint;
    draws.all += of_keypoint;
    draws.inliers += best[k] < 0 ? 0.0 : preference_[best[k]] / (end - begin);
    ++draws.num_keypoints;
  }
  // Sum over the cameras, weighted by the probability that the first draw is from the camera.
  double probability = 0.0;
  for (const Draws& draws : cameras) {
    if (draws.num_keypoints >= sample_size()) {
      probability += draws.all / all * std::pow(draws.inliers / draws.all, sample_size());
    }
  }
  return probability;
}

}  // namespace cairn
