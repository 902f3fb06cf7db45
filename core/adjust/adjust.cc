#include "core/adjust/adjust.h"

#include <algorithm>
#include <cmath>

#include "core/adjust/adjust_problem.h"
#include "core/adjust/adjustable_camera.h"
#include "core/adjust/landmark_roles.h"
#include "core/check.h"
#include "core/parallel_for.h"
#include "core/rotation_between.h"
#include "core/scene/triangulate.h"

namespace cairn {
namespace {

constexpr int kLandmarksPerStep = 4096;

// Cameras and the values of their unknowns.
struct Cameras {
  std::vector<AdjustableCamera> adjustable;
  std::vector<CameraUnknowns> unknowns;
};

Cameras CamerasOf(const Reconstruction& model) {
  Cameras cameras;
  for (const Camera& camera : model.cameras) {
    cameras.adjustable.emplace_back(camera);
    cameras.unknowns.push_back(cameras.adjustable.back().start());
  }
  return cameras;
}

// Triangulates the landmarks that follow with the poses and the cameras as they are now. Those that
// cannot be keep their place, and their errors tell.
void TriangulateFollowing(const Cameras& cameras, const std::vector<LandmarkRole>& roles,
                          int num_threads, Reconstruction* model) {
  std::vector<Camera> camera_now;
  for (size_t i = 0; i < cameras.adjustable.size(); ++i) {
    camera_now.push_back(cameras.adjustable[i].With(cameras.unknowns[i]));
  }
  const int num_landmarks = static_cast<int>(model->landmarks.size());
  const int num_steps = (num_landmarks + kLandmarksPerStep - 1) / kLandmarksPerStep;
  ParallelFor(num_steps, num_threads, [&](int step) {
    const int end = std::min(num_landmarks, (step + 1) * kLandmarksPerStep);
    for (int i = step * kLandmarksPerStep; i < end; ++i) {
      if (roles[i] != LandmarkRole::kFollows) {
        continue;
      }
      ReconLandmark& landmark = model->landmarks[i];
      std::vector<PointObservation> observations = PointObservationsOf(*model, landmark);
      for (size_t k = 0; k < observations.size(); ++k) {
        const ReconImage& image = model->images[landmark.observations[k].image_idx];
        observations[k].camera = &camera_now[image.camera_idx];
      }
      landmark.x_in_world = TriangulatePoint(observations).value_or(landmark.x_in_world);
    }
  });
}

// What the landmarks keep, and the errors of what they keep.
struct Kept {
  double sum_sq_px = 0.0;
  int64_t num_observations = 0;
  int64_t num_removed = 0;
};

// The largest angle between the ray that is farthest from the mean ray and another.
double RayAngleRad(const Reconstruction& model, const ReconLandmark& landmark) {
  std::vector<Eigen::Vector3d> rays;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const ReconObservation& seen : landmark.observations) {
    const Rigid3d& cam_from_world = model.images[seen.image_idx].cam_from_world;
    rays.push_back((landmark.x_in_world - cam_from_world.Inverse().translation).normalized());
    mean += rays.back();
  }
  const auto farther_from = [&rays](const Eigen::Vector3d& ray) {
    return *std::min_element(rays.begin(), rays.end(),
                             [&](const auto& a, const auto& b) { return a.dot(ray) < b.dot(ray); });
  };
  const Eigen::Vector3d first = farther_from(mean);
  const Eigen::Vector3d second = farther_from(first);
  return AngleBetweenRad(first, second);
}

// Removes the observations of a landmark that do not project or, above `max_error_sigmas`, do not
// fit. Removes all if fewer than two would stay, or if the rays span too little, unless its
// position is fixed.
Kept KeepFitting(const Cameras& cameras, const Reconstruction& model, double max_error_sigmas,
                 double min_ray_angle_rad, bool is_fixed, ReconLandmark* landmark) {
  Kept kept;
  const auto fits = [&](const ReconObservation& seen) {
    const ReconImage& image = model.images[seen.image_idx];
    const Keypoint& keypoint = image.features.keypoints[seen.keypoint_idx];
    Eigen::Vector2d pixel;
    if (!cameras.adjustable[image.camera_idx].Project(cameras.unknowns[image.camera_idx],
                                                      image.cam_from_world * landmark->x_in_world,
                                                      &pixel, nullptr, nullptr)) {
      return false;
    }
    const double sq_px = (pixel - Eigen::Vector2d(keypoint.x_px, keypoint.y_px)).squaredNorm();
    const double limit_px = max_error_sigmas * KeypointSigmaPx(keypoint.scale_px);
    if (!(sq_px <= limit_px * limit_px)) {
      return false;
    }
    kept.sum_sq_px += sq_px;
    return true;
  };
  const size_t before = landmark->observations.size();
  std::vector<ReconObservation>& observations = landmark->observations;
  observations.erase(std::stable_partition(observations.begin(), observations.end(), fits),
                     observations.end());
  if (!is_fixed &&
      (observations.size() < 2 ||
       (min_ray_angle_rad > 0.0 && RayAngleRad(model, *landmark) < min_ray_angle_rad))) {
    observations.clear();
    kept.sum_sq_px = 0.0;
  }
  kept.num_observations = static_cast<int64_t>(observations.size());
  kept.num_removed = static_cast<int64_t>(before - observations.size());
  return kept;
}

// KeepFitting for all landmarks; those without observations leave the model and `is_fixed`. Sums
// are added up in the order of the landmarks.
Kept RemoveOutliers(const Cameras& cameras, double max_error_sigmas, double min_ray_angle_rad,
                    int num_threads, Reconstruction* model, std::vector<uint8_t>* is_fixed) {
  const int num_landmarks = static_cast<int>(model->landmarks.size());
  const int num_steps = (num_landmarks + kLandmarksPerStep - 1) / kLandmarksPerStep;
  std::vector<Kept> kept_of_step(num_steps);
  ParallelFor(num_steps, num_threads, [&](int step) {
    Kept& kept = kept_of_step[step];
    const int end = std::min(num_landmarks, (step + 1) * kLandmarksPerStep);
    for (int i = step * kLandmarksPerStep; i < end; ++i) {
      const Kept of_landmark =
          KeepFitting(cameras, *model, max_error_sigmas, min_ray_angle_rad,
                      !is_fixed->empty() && (*is_fixed)[i] != 0, &model->landmarks[i]);
      kept.sum_sq_px += of_landmark.sum_sq_px;
      kept.num_observations += of_landmark.num_observations;
      kept.num_removed += of_landmark.num_removed;
    }
  });
  if (!is_fixed->empty()) {
    size_t kept_flags = 0;
    for (int i = 0; i < num_landmarks; ++i) {
      if (!model->landmarks[i].observations.empty()) {
        (*is_fixed)[kept_flags++] = (*is_fixed)[i];
      }
    }
    is_fixed->resize(kept_flags);
  }
  std::erase_if(model->landmarks,
                [](const ReconLandmark& landmark) { return landmark.observations.empty(); });
  Kept all;
  for (const Kept& kept : kept_of_step) {
    all.sum_sq_px += kept.sum_sq_px;
    all.num_observations += kept.num_observations;
    all.num_removed += kept.num_removed;
  }
  return all;
}

void CheckSizes(std::span<const CameraFreedom> freedom_of_camera, const AdjustPriors& priors,
                const Reconstruction& model) {
  const auto is_absent_or = [](size_t size, size_t count) { return size == 0 || size == count; };
  CAIRN_CHECK(freedom_of_camera.size() == model.cameras.size(), "a freedom a camera");
  CAIRN_CHECK(is_absent_or(priors.position_of_image.size(), model.images.size()),
              "a position an image");
  CAIRN_CHECK(is_absent_or(priors.image_is_fixed.size(), model.images.size()), "a flag an image");
  CAIRN_CHECK(is_absent_or(priors.focal_sigma_of_camera.size(), model.cameras.size()),
              "a sigma a camera");
  CAIRN_CHECK(is_absent_or(priors.camera_means.size(), model.cameras.size()), "a mean a camera");
  CAIRN_CHECK(is_absent_or(priors.landmark_is_fixed.size(), model.landmarks.size()),
              "a flag a landmark");
}

}  // namespace

AdjustReport Adjust(std::span<const CameraFreedom> freedom_of_camera,
                    const AdjustPriors& given_priors, const AdjustOptions& options,
                    Reconstruction& model, const AdjustProgress& progress) {
  options.Validate();
  CheckSizes(freedom_of_camera, given_priors, model);
  AdjustPriors priors = given_priors;  // Flags of landmarks go as landmarks do.
  constexpr double kAnyError = 1e300;
  const size_t num_landmarks = model.landmarks.size();
  Cameras cameras = CamerasOf(model);
  AdjustReport report;
  // The solver starts where every observation projects.
  Kept kept = RemoveOutliers(cameras, kAnyError, 0.0, options.num_threads, &model,
                             &priors.landmark_is_fixed);
  report.num_observations_removed = kept.num_removed;
  for (int round = 0; round < options.max_rounds && kept.num_observations > 0; ++round) {
    AdjustProblem problem(freedom_of_camera, cameras.adjustable, priors, options, model);
    problem.StartFrom(cameras.unknowns);
    const ceres::Solver::Summary summary = problem.Solve([&](int iteration) {
      if (progress) {
        progress(round * options.max_iterations + iteration,
                 options.max_rounds * options.max_iterations);
      }
    });
    problem.Store(cameras.unknowns, &model);
    TriangulateFollowing(cameras, problem.roles(), options.num_threads, &model);
    report.num_rounds = round + 1;
    report.num_iterations += summary.num_successful_steps + summary.num_unsuccessful_steps;
    report.initial_cost = round == 0 ? summary.initial_cost : report.initial_cost;
    report.final_cost = summary.final_cost;
    kept = RemoveOutliers(cameras, options.max_error_sigmas, options.min_ray_angle_rad,
                          options.num_threads, &model, &priors.landmark_is_fixed);
    report.num_observations_removed += kept.num_removed;
    if (kept.num_removed == 0) {
      break;
    }
  }
  for (size_t i = 0; i < model.cameras.size(); ++i) {
    model.cameras[i] = cameras.adjustable[i].With(cameras.unknowns[i]);
  }
  report.num_observations = kept.num_observations;
  report.num_landmarks_removed = static_cast<int64_t>(num_landmarks - model.landmarks.size());
  if (kept.num_observations > 0) {
    report.rms_px = std::sqrt(kept.sum_sq_px / static_cast<double>(kept.num_observations));
  }
  return report;
}

}  // namespace cairn
