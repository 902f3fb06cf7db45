// Builds one bundle adjustment over a window in Ceres and solves it with an exact number of
// iterations.
#ifndef CAIRN_LAB_RIVALS_FUSION_WINDOW_PROBLEM_H_
#define CAIRN_LAB_RIVALS_FUSION_WINDOW_PROBLEM_H_

#include <ceres/loss_function.h>
#include <ceres/ordered_groups.h>
#include <ceres/problem.h>

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "lab/rivals/fusion/bundle_adjuster_options.h"
#include "lab/rivals/fusion/factors.h"
#include "lab/rivals/fusion/marginal_prior.h"
#include "lab/rivals/fusion/window_tracks.h"
#include "lab/rivals/fusion/window_variables.h"

namespace cairn::fusion {

// Statistics of one optimization.
struct AdjustmentSummary {
  int num_iterations = 0;  // Levenberg-Marquardt steps, accepted or not.
  int num_local_residuals = 0;
  int num_global_residuals = 0;  // Observations of map landmarks.
  double initial_cost = 0.0;
  double final_cost = 0.0;
};

// Cost functions of one kind. They are allocated once and reused from problem to problem.
template <typename Factor>
class FactorPool {
 public:
  Factor* Next() {
    if (num_used_ == factors_.size()) {
      factors_.push_back(std::make_unique<Factor>());
    }
    return factors_[num_used_++].get();
  }
  void Reset() { num_used_ = 0; }
  size_t num_used() const { return num_used_; }

 private:
  std::vector<std::unique_ptr<Factor>> factors_;
  size_t num_used_ = 0;
};

// Returns the standard deviation, on the plane z = 1, of an observation of a map landmark: the
// pixel noise plus the landmark's own error at its depth. If M cameras see the landmark, each
// observation gets sqrt(M) times the landmark's standard deviation, as in the filter
// (map_update.h).
double GlobalObservationSigma(const BundleAdjusterOptions& options, const MapLandmark& landmark,
                              size_t num_observations, double depth_m);

// Keeps its cost functions from one window to the next. Not thread-safe.
class WindowProblem {
 public:
  explicit WindowProblem(const BundleAdjusterOptions& options);

  // Optimizes the blocks of `cameras` (at least 2, ordered by time, all rebased), the landmarks of
  // `tracks` and, if not null, `alignment`. If `prior` is null, the heading, position and biases of
  // the oldest camera are held as the options say.
  AdjustmentSummary Solve(std::span<WindowCamera* const> cameras, WindowAlignment* alignment,
                          std::span<WindowTrack* const> tracks, const MarginalPrior* prior);

 private:
  void AddInertial(std::span<WindowCamera* const> cameras, ceres::Problem* problem);
  void AddTrack(WindowTrack* track, WindowAlignment* alignment, ceres::Problem* problem);
  void AddPrior(WindowCamera* oldest, const MarginalPrior* prior, ceres::Problem* problem);

  const BundleAdjusterOptions& options_;
  PrepareVariables prepare_;
  ceres::HuberLoss loss_;
  FactorPool<LocalFactor> local_factors_;
  FactorPool<GlobalFactor> global_factors_;
  FactorPool<ImuFactor> imu_factors_;
  GaugeFactor gauge_factor_;
  BiasFactor bias_factor_;
  std::optional<MarginalPriorFactor> prior_factor_;
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_WINDOW_PROBLEM_H_
