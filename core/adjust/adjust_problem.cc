#include "core/adjust/adjust_problem.h"

#include <ceres/iteration_callback.h>
#include <ceres/loss_function.h>
#include <ceres/ordered_groups.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <limits>
#include <memory>

#include "core/adjust/adjust_costs.h"
#include "core/adjust/pose_solver.h"
#include "core/adjust/quiet_ceres.h"
#include "core/error.h"
#include "core/focal_length.h"
#include "core/scene/triangulate.h"

namespace cairn {
namespace {

ceres::LinearSolverType CeresSolver(PoseSolver solver) {
  switch (solver) {
    case PoseSolver::kDense:
      return ceres::DENSE_SCHUR;
    case PoseSolver::kSparse:
      return ceres::SPARSE_SCHUR;
    case PoseSolver::kIterations:
      return ceres::ITERATIVE_SCHUR;
  }
  return ceres::SPARSE_SCHUR;
}

// Keeps what the progress throws, since nothing may be thrown through Ceres.
class IterationReporter final : public ceres::IterationCallback {
 public:
  explicit IterationReporter(const std::function<void(int)>& progress) : progress_(progress) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    try {
      progress_(summary.iteration);
    } catch (...) {
      thrown_ = std::current_exception();
      return ceres::SOLVER_ABORT;
    }
    return ceres::SOLVER_CONTINUE;
  }

  void Rethrow() const {
    if (thrown_) {
      std::rethrow_exception(thrown_);
    }
  }

 private:
  const std::function<void(int)>& progress_;
  std::exception_ptr thrown_;
};

}  // namespace

AdjustProblem::AdjustProblem(std::span<const CameraFreedom> freedom_of_camera,
                             std::span<const AdjustableCamera> cameras, const AdjustPriors& priors,
                             const AdjustOptions& options, const Reconstruction& model)
    : freedom_of_camera_(freedom_of_camera),
      cameras_(cameras),
      priors_(priors),
      options_(options),
      model_(model),
      num_observations_(model.images.size(), 0),
      roles_(RolesOfLandmarks(model, priors, options.max_observations_of_all)) {
  poses_at_ = kPointStride * model.landmarks.size();
  cameras_at_ = poses_at_ + kPoseStride * model.images.size();
  values_.resize(cameras_at_ + kCameraStride * model.cameras.size());
  for (size_t i = 0; i < model.landmarks.size(); ++i) {
    Eigen::Map<Eigen::Vector3d>{PointAt(i)} = model.landmarks[i].x_in_world;
  }
  for (size_t i = 0; i < model.images.size(); ++i) {
    StorePose(model.images[i].cam_from_world, PoseAt(i));
  }
  for (size_t i = 0; i < cameras.size(); ++i) {
    Eigen::Map<CameraUnknowns>{CameraAt(i)} = cameras[i].start();
  }
  AddObservations();
  AddCameras();
  AddPositions();
  FixGauge();
}

void AdjustProblem::AddObservations() {
  auto* loss = new ceres::CauchyLoss(options_.loss_scale_sigmas);
  for (size_t i = 0; i < model_.landmarks.size(); ++i) {
    if (roles_[i] != LandmarkRole::kDecides) {
      continue;
    }
    for (const ReconObservation& seen : model_.landmarks[i].observations) {
      const ReconImage& image = model_.images[seen.image_idx];
      const Keypoint& keypoint = image.features.keypoints[seen.keypoint_idx];
      problem_.AddResidualBlock(new ReprojectionCost(&cameras_[image.camera_idx],
                                                     Eigen::Vector2d(keypoint.x_px, keypoint.y_px),
                                                     KeypointSigmaPx(keypoint.scale_px)),
                                loss, PointAt(i), PoseAt(seen.image_idx),
                                CameraAt(image.camera_idx));
      ++num_observations_[seen.image_idx];
    }
    if (priors_.HoldsLandmark(i)) {
      problem_.SetParameterBlockConstant(PointAt(i));
      ++num_fixed_landmarks_;
    }
  }
  for (size_t i = 0; i < model_.images.size(); ++i) {
    if (num_observations_[i] > 0) {
      problem_.SetManifold(PoseAt(i), new PoseManifold());
      if (priors_.HoldsImage(i)) {
        problem_.SetParameterBlockConstant(PoseAt(i));
      }
    }
  }
}

CameraUnknowns AdjustProblem::CameraMean(size_t camera) const {
  if (priors_.camera_means.empty()) {
    return cameras_[camera].start();
  }
  const Camera& mean = priors_.camera_means[camera];
  CameraUnknowns unknowns = AdjustableCamera(mean).start();
  unknowns[0] = std::log(mean.focal_px() / model_.cameras[camera].focal_px());
  unknowns.tail<2>() = PrincipalPointPx(mean) - PrincipalPointPx(model_.cameras[camera]);
  return unknowns;
}

void AdjustProblem::AddCameras() {
  constexpr double kNothing = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < cameras_.size(); ++i) {
    if (!problem_.HasParameterBlock(CameraAt(i))) {
      continue;
    }
    const CameraFreedom freedom = freedom_of_camera_[i];
    if (freedom == CameraFreedom::kFixed) {
      problem_.SetParameterBlockConstant(CameraAt(i));
      continue;
    }
    const double focal_sigma =
        priors_.focal_sigma_of_camera.empty() ? 0.0 : priors_.focal_sigma_of_camera[i];
    const bool is_bent =
        freedom >= CameraFreedom::kFocalAndDistortion && cameras_[i].has_free_distortion();
    const bool is_shifted = freedom == CameraFreedom::kWithPrincipalPoint;
    std::vector<int> held;
    if (!is_bent) {
      held.insert(held.end(), {1, 2});
    }
    if (!is_shifted) {
      held.insert(held.end(), {3, 4});
    }
    if (!held.empty()) {
      problem_.SetManifold(CameraAt(i), new ceres::SubsetManifold(kCameraSize, held));
    }
    const double distortion_sigma = is_bent ? options_.distortion_sigma : kNothing;
    CameraUnknowns sigma = CameraUnknowns::Constant(kNothing);
    sigma.head<3>() << (focal_sigma > 0.0 ? focal_sigma : kNothing), distortion_sigma,
        distortion_sigma;
    problem_.AddResidualBlock(new CameraPriorCost(CameraMean(i), sigma), nullptr, CameraAt(i));
    if (is_shifted) {
      AddPrincipalPoint(i);
    }
  }
}

void AdjustProblem::AddPrincipalPoint(size_t camera) {
  const Camera& before = model_.cameras[camera];
  CameraUnknowns sigma = CameraUnknowns::Constant(std::numeric_limits<double>::infinity());
  sigma.tail<2>().setConstant(options_.principal_point_loss_scale *
                              std::max(before.width_px(), before.height_px()));
  problem_.AddResidualBlock(new CameraPriorCost(CameraMean(camera), sigma),
                            new ceres::CauchyLoss(1.0), CameraAt(camera));
}

void AdjustProblem::AddPositions() {
  for (size_t i = 0; i < priors_.position_of_image.size(); ++i) {
    const auto& position = priors_.position_of_image[i];
    if (position && num_observations_[i] > 0 && !priors_.HoldsImage(i)) {
      problem_.AddResidualBlock(new PositionCost(position->center_in_world, position->sigma_m),
                                new ceres::CauchyLoss(options_.position_loss_scale_sigmas),
                                PoseAt(i));
    }
  }
}

void AdjustProblem::FixGauge() {
  int num_positions = 0, num_fixed = 0;
  size_t anchor = 0;
  for (size_t i = 0; i < num_observations_.size(); ++i) {
    if (num_observations_[i] == 0) {
      continue;
    }
    num_fixed += priors_.HoldsImage(i) ? 1 : 0;
    num_positions += !priors_.position_of_image.empty() && priors_.position_of_image[i] ? 1 : 0;
    const bool is_better =
        num_observations_[anchor] == 0 || (priors_.HoldsImage(i) == priors_.HoldsImage(anchor)
                                               ? num_observations_[i] > num_observations_[anchor]
                                               : priors_.HoldsImage(i));
    if (is_better) {
      anchor = i;
    }
  }
  if (num_fixed >= 2 || num_positions >= 3 || num_fixed_landmarks_ >= 3 ||
      problem_.NumResidualBlocks() == 0) {
    return;
  }
  if (num_observations_[anchor] == 0) {
    return;  // No image has observations, so the problem knows no pose.
  }
  problem_.SetParameterBlockConstant(PoseAt(anchor));
  HoldScale(anchor);
}

void AdjustProblem::HoldScale(size_t anchor) {
  const Eigen::Map<const Eigen::Vector3d> from(PoseAt(anchor) + 4);
  size_t farthest = anchor;
  Eigen::Vector3d baseline = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < num_observations_.size(); ++i) {
    const Eigen::Vector3d to = Eigen::Map<const Eigen::Vector3d>(PoseAt(i) + 4) - from;
    if (num_observations_[i] > 0 && to.squaredNorm() > baseline.squaredNorm()) {
      farthest = i;
      baseline = to;
    }
  }
  if (farthest == anchor) {
    return;
  }
  int axis = 0;
  baseline.cwiseAbs().maxCoeff(&axis);
  problem_.SetManifold(PoseAt(farthest), new PoseOnPlaneManifold(axis));
}

void AdjustProblem::StartFrom(std::span<const CameraUnknowns> unknowns) {
  for (size_t i = 0; i < unknowns.size(); ++i) {
    Eigen::Map<CameraUnknowns>{CameraAt(i)} = unknowns[i];
  }
}

ceres::Solver::Summary AdjustProblem::Solve(const std::function<void(int)>& progress) {
  ceres::Solver::Options options = QuietCeresOptions();
  // One thread: Ceres adds up the sums of several threads in the order in which they end.
  // Eigen's factorization: CHOLMOD's would call a BLAS that divides sums by the number of cores.
  options.num_threads = 1;
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.dense_linear_algebra_library_type = ceres::EIGEN;
  options.linear_solver_type = CeresSolver(SolverOfPoses(model_, roles_, priors_));
  options.preconditioner_type = ceres::SCHUR_JACOBI;  // Of the iterations.
  options.max_num_iterations = options_.max_iterations;
  options.function_tolerance = options_.min_relative_change;
  // Rounding can make a system with very distant landmarks that cannot be factored. Ceres then
  // tries a shorter step. After at most 18 of them the trust region has its least radius, and Ceres
  // stops with the best state so far. By default Ceres would report a failure after five.
  options.max_num_consecutive_invalid_steps = 50;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (size_t i = 0; i < model_.landmarks.size(); ++i) {
    if (roles_[i] == LandmarkRole::kDecides) {
      ordering->AddElementToGroup(PointAt(i), 0);
    }
  }
  for (size_t i = 0; i < model_.images.size(); ++i) {
    if (num_observations_[i] > 0) {
      ordering->AddElementToGroup(PoseAt(i), 1);
    }
  }
  for (size_t i = 0; i < cameras_.size(); ++i) {
    if (problem_.HasParameterBlock(CameraAt(i))) {
      ordering->AddElementToGroup(CameraAt(i), 1);
    }
  }
  options.linear_solver_ordering = ordering;
  IterationReporter reporter(progress);
  options.callbacks.push_back(&reporter);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem_, &summary);
  reporter.Rethrow();
  if (!summary.IsSolutionUsable()) {
    throw Error(ErrorCode::kInternal, fmt::format("the bundle adjustment of {} photos failed: {}",
                                                  model_.images.size(), summary.message));
  }
  return summary;
}

void AdjustProblem::Store(std::span<CameraUnknowns> unknowns, Reconstruction* model) const {
  for (size_t i = 0; i < model->landmarks.size(); ++i) {
    if (roles_[i] == LandmarkRole::kDecides) {
      model->landmarks[i].x_in_world = Eigen::Map<const Eigen::Vector3d>(PointAt(i));
    }
  }
  for (size_t i = 0; i < model->images.size(); ++i) {
    if (num_observations_[i] > 0 && !priors_.HoldsImage(i)) {
      model->images[i].cam_from_world = LoadPose(PoseAt(i));
    }
  }
  for (size_t i = 0; i < unknowns.size(); ++i) {
    unknowns[i] = Eigen::Map<const CameraUnknowns>(CameraAt(i));
  }
}

}  // namespace cairn
