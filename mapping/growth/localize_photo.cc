#include "mapping/growth/localize_photo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/adjust/adjust.h"
#include "core/error.h"
#include "core/random.h"
#include "core/scene/reconstruction.h"
#include "engine/pose/consensus.h"
#include "engine/pose/p3p.h"
#include "engine/pose/ransac.h"
#include "engine/pose/refine_pose.h"

namespace cairn {
namespace {

struct ObservationRays {
  std::vector<RayObservation> rays;  // In random order.
  std::vector<int> observation_of_ray;
};

ObservationRays MakeObservationRays(const Camera& camera,
                                    const std::vector<LandmarkObservation>& observations,
                                    uint64_t seed) {
  std::vector<int> order(observations.size());
  std::iota(order.begin(), order.end(), 0);
  Random random(seed);
  for (int i = static_cast<int>(order.size()) - 1; i > 0; --i) {
    std::swap(order[i], order[random.Index(i + 1)]);
  }
  ObservationRays result;
  for (const int i : order) {
    if (const auto ray = camera.Unproject(observations[i].pixel)) {
      RayObservation observation;
      observation.ray_in_cam = *ray;
      observation.x_in_anchor = observations[i].x_in_world;
      observation.threshold_rad = kMaxDraftSigmas * observations[i].SigmaPx() / camera.focal_px();
      observation.keypoint_idx = observations[i].keypoint_idx;
      result.rays.push_back(observation);
      result.observation_of_ray.push_back(i);
    }
  }
  return result;
}

// See LoRansac for the contract of the methods.
class ObservationProblem {
 public:
  using Model = Eigen::Matrix<double, 3, 4>;  // cam_from_world.
  static constexpr int kMaxModels = 4;

  ObservationProblem(const Camera& camera, const std::vector<LandmarkObservation>& observations,
                     const ObservationRays& rays)
      : camera_(camera), observations_(observations), rays_(rays), consensus_(rays.rays) {}

  int SampleModels(Random* random, std::array<Model, kMaxModels>* models) const {
    const int count = static_cast<int>(rays_.rays.size());
    std::array<int, 3> sample;
    for (int i = 0; i < 3; ++i) {
      do {
        sample[i] = random->Index(count);
      } while (std::find(sample.begin(), sample.begin() + i, sample[i]) != sample.begin() + i);
    }
    std::array<Eigen::Vector3d, 3> bearings, points;
    for (int i = 0; i < 3; ++i) {
      bearings[i] = rays_.rays[sample[i]].ray_in_cam;
      points[i] = rays_.rays[sample[i]].x_in_anchor;
    }
    return SolveP3p(bearings, points, models);
  }

  double ScoreMinimal(const Model& model, double score_to_beat) {
    return consensus_.Gain(model, 0.0, score_to_beat);
  }

  std::optional<std::pair<Model, double>> Optimize(const Model& model) {
    constexpr int kRounds = 2;
    Model best = model;
    for (int round = 0; round < kRounds; ++round) {
      const std::vector<PoseObservation> inliers = Observations(InliersOf(best));
      if (inliers.size() < 4) {
        return std::nullopt;
      }
      const Rigid3d pose(Eigen::Matrix3d(best.leftCols<3>()), Eigen::Vector3d(best.col(3)));
      best = RefinePose(camera_, inliers, std::nullopt, pose, RefinePoseOptions())
                 .cam_from_anchor.ToMatrix();
    }
    return std::pair(best, consensus_.Gain(best, 0.0, -1.0));
  }

  double InlierSampleProbability(const Model& model) {
    return SampleProbabilityOfScore(static_cast<double>(InliersOf(model).size()));
  }
  double SampleProbabilityOfScore(double score) const {
    return std::pow(score / static_cast<double>(rays_.rays.size()), 3);
  }

  // Indices of rays.
  std::vector<int> InliersOf(const Model& model) {
    std::vector<int> inliers;
    for (const int best : consensus_.BestObservations(model, 0.0)) {
      if (best >= 0) {
        inliers.push_back(best);
      }
    }
    return inliers;
  }

 private:
  std::vector<PoseObservation> Observations(const std::vector<int>& inliers) const {
    std::vector<PoseObservation> observations;
    for (const int i : inliers) {
      const LandmarkObservation& observation = observations_[rays_.observation_of_ray[i]];
      observations.push_back({observation.pixel, observation.x_in_world});
    }
    return observations;
  }

  const Camera& camera_;
  const std::vector<LandmarkObservation>& observations_;
  const ObservationRays& rays_;
  ConsensusSet consensus_;
};

}  // namespace

std::optional<LocalizedPhoto> LocalizePhoto(std::span<const Camera> cameras,
                                            const std::vector<LandmarkObservation>& observations,
                                            int min_inliers, uint64_t seed) {
  std::optional<LocalizedPhoto> best;
  for (const Camera& camera : cameras) {
    const ObservationRays rays = MakeObservationRays(camera, observations, seed);
    if (static_cast<int>(rays.rays.size()) < min_inliers) {
      continue;
    }
    ObservationProblem problem(camera, observations, rays);
    const auto result = LoRansac(&problem, RansacOptions(), seed);
    if (!result.model) {
      continue;
    }
    const int num_inliers = static_cast<int>(problem.InliersOf(*result.model).size());
    if (num_inliers >= min_inliers && (!best || num_inliers > best->num_inliers)) {
      best = LocalizedPhoto{Rigid3d(Eigen::Matrix3d(result.model->leftCols<3>()),
                                    Eigen::Vector3d(result.model->col(3))),
                            camera, num_inliers};
    }
  }
  return best;
}

void FitPart(const MappingCamera& known, const std::vector<LandmarkObservation>& observations,
             LocalizedPhoto* photo) {
  Reconstruction model;
  model.cameras = {photo->camera};
  ReconImage& image = model.images.emplace_back();
  image.cam_from_world = photo->cam_from_world;
  for (const LandmarkObservation& seen : observations) {
    model.landmarks.push_back({seen.x_in_world, {{0, image.features.size()}}});
    image.features.keypoints.push_back({static_cast<float>(seen.pixel.x()),
                                        static_cast<float>(seen.pixel.y()), seen.scale_px, 0.0F});
  }
  AdjustPriors priors;
  priors.focal_sigma_of_camera = {known.focal.log_sigma};
  priors.camera_means = {known.camera};
  priors.landmark_is_fixed.assign(model.landmarks.size(), 1);
  AdjustOptions options;
  options.max_error_sigmas = kMaxDraftSigmas;
  constexpr CameraFreedom kFreedom[] = {CameraFreedom::kWithPrincipalPoint};
  try {
    const AdjustReport report = Adjust(kFreedom, priors, options, model);
    if (report.num_observations > photo->num_inliers) {
      *photo = {model.images[0].cam_from_world, model.cameras[0],
                static_cast<int>(report.num_observations)};
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInternal) {
      throw;  // The solver may fail; then the pose is what it was.
    }
  }
}

}  // namespace cairn
