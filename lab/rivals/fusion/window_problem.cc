#include "lab/rivals/fusion/window_problem.h"

#include <ceres/solver.h>

#include <algorithm>
#include <cmath>

#include "core/adjust/quiet_ceres.h"

namespace cairn::fusion {
namespace {

// Elimination order: landmarks first, then everything else.
constexpr int kLandmarkGroup = 0;
constexpr int kCameraGroup = 1;

ceres::Problem::Options ProblemOptions(PrepareVariables* prepare) {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  options.evaluation_callback = prepare;
  return options;
}

ceres::Solver::Options SolverOptions(int num_iterations) {
  ceres::Solver::Options options = QuietCeresOptions();
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.dense_linear_algebra_library_type = ceres::EIGEN;
  options.num_threads = 1;
  // Zero tolerances make the number of iterations exact.
  options.max_num_iterations = num_iterations;
  options.function_tolerance = 0.0;
  options.gradient_tolerance = 0.0;
  options.parameter_tolerance = 0.0;
  return options;
}

}  // namespace

double GlobalObservationSigma(const BundleAdjusterOptions& options, const MapLandmark& landmark,
                              size_t num_observations, double depth_m) {
  const double pixel = options.match_sigma_px / options.camera.focal_px();
  const double map_variance = landmark.sigma_m * landmark.sigma_m *
                              static_cast<double>(num_observations) / (depth_m * depth_m);
  return std::sqrt(pixel * pixel + map_variance);
}

WindowProblem::WindowProblem(const BundleAdjusterOptions& options)
    : options_(options), prepare_(options.rig), loss_(options.huber_sigmas) {}

AdjustmentSummary WindowProblem::Solve(std::span<WindowCamera* const> cameras,
                                       WindowAlignment* alignment,
                                       std::span<WindowTrack* const> tracks,
                                       const MarginalPrior* prior) {
  prepare_.Watch({cameras.begin(), cameras.end()}, alignment);
  prepare_.Prepare();
  local_factors_.Reset();
  global_factors_.Reset();
  imu_factors_.Reset();
  ordering_ = std::make_shared<ceres::ParameterBlockOrdering>();

  ceres::Problem problem(ProblemOptions(&prepare_));
  AddPrior(cameras.front(), prior, &problem);
  AddInertial(cameras, &problem);
  for (WindowTrack* track : tracks) {
    AddTrack(track, alignment, &problem);
  }
  for (WindowCamera* camera : cameras) {
    ordering_->AddElementToGroup(camera->pose.data(), kCameraGroup);
    ordering_->AddElementToGroup(camera->motion.data(), kCameraGroup);
  }
  if (alignment != nullptr && problem.HasParameterBlock(alignment->block.data())) {
    ordering_->AddElementToGroup(alignment->block.data(), kCameraGroup);
  }
  if (local_factors_.num_used() == 0) {  // DENSE_SCHUR must eliminate something.
    ordering_->AddElementToGroup(cameras.front()->motion.data(), kLandmarkGroup);
  }

  ceres::Solver::Options solver_options = SolverOptions(options_.num_iterations);
  solver_options.linear_solver_ordering = ordering_;
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options, &problem, &summary);
  return {.num_iterations = static_cast<int>(summary.iterations.size()) - 1,
          .num_local_residuals = static_cast<int>(local_factors_.num_used()),
          .num_global_residuals = static_cast<int>(global_factors_.num_used()),
          .initial_cost = summary.initial_cost,
          .final_cost = summary.final_cost};
}

void WindowProblem::AddInertial(std::span<WindowCamera* const> cameras, ceres::Problem* problem) {
  for (size_t i = 1; i < cameras.size(); ++i) {
    WindowCamera* from = cameras[i - 1];
    WindowCamera* to = cameras[i];
    ImuFactor* factor = imu_factors_.Next();
    factor->Set(from, to, options_.gravity_m_s2);
    problem->AddResidualBlock(factor, nullptr, from->pose.data(), from->motion.data(),
                              to->pose.data(), to->motion.data());
  }
}

void WindowProblem::AddTrack(WindowTrack* track, WindowAlignment* alignment,
                             ceres::Problem* problem) {
  if (!track->map_landmark) {
    const double sigma = options_.track_sigma_px / options_.camera.focal_px();
    for (const WindowObservation& observation : track->observations) {
      LocalFactor* factor = local_factors_.Next();
      factor->Set(observation.camera, observation.normalized, sigma);
      problem->AddResidualBlock(factor, &loss_, observation.camera->pose.data(),
                                track->x_in_local.data());
    }
    ordering_->AddElementToGroup(track->x_in_local.data(), kLandmarkGroup);
    return;
  }
  const Eigen::Vector3d x_in_local = alignment->ToLocal(track->map_landmark->x_in_global);
  for (const WindowObservation& observation : track->observations) {
    const WindowCamera& camera = *observation.camera;
    const double depth_m = camera.ToCam(x_in_local).z();
    if (depth_m < options_.triangulate.min_depth_m) {
      continue;
    }
    GlobalFactor* factor = global_factors_.Next();
    factor->Set(
        observation.camera, alignment, observation.normalized,
        GlobalObservationSigma(options_, *track->map_landmark, track->observations.size(), depth_m),
        track->map_landmark->x_in_global);
    problem->AddResidualBlock(factor, &loss_, observation.camera->pose.data(),
                              alignment->block.data());
  }
}

void WindowProblem::AddPrior(WindowCamera* oldest, const MarginalPrior* prior,
                             ceres::Problem* problem) {
  if (prior != nullptr) {
    prior_factor_.emplace(*prior);
    std::vector<double*> variables;
    for (const PriorBlock& block : prior->blocks) {
      variables.push_back(block.variables());
    }
    problem->AddResidualBlock(&*prior_factor_, nullptr, variables);
    return;
  }
  const ImuState state = oldest->State();
  gauge_factor_.Set(state.local_from_imu.translation, options_.gauge_sigma_rad,
                    options_.gauge_sigma_m);
  problem->AddResidualBlock(&gauge_factor_, nullptr, oldest->pose.data());
  bias_factor_.Set(state.gyro_bias, state.accel_bias, options_.gyro_bias_sigma_rad_s,
                   options_.accel_bias_sigma_m_s2);
  problem->AddResidualBlock(&bias_factor_, nullptr, oldest->motion.data());
}

}  // namespace cairn::fusion
