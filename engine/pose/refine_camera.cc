#include "engine/pose/refine_camera.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/least_squares.h"
#include "engine/pose/m_estimate.h"
#include "engine/pose/normal_equations.h"
#include "engine/pose/pose_residuals.h"

namespace cairn {
namespace {

// Six parameters of the pose, the logarithm of the focal length, the radial coefficient.
constexpr int kNumParams = 8;
constexpr int kFocal = 6, kRadial = 7;
using Vector8d = Eigen::Matrix<double, kNumParams, 1>;
using Matrix8d = Eigen::Matrix<double, kNumParams, kNumParams>;
using Jacobian8d = Eigen::Matrix<double, 2, kNumParams>;

constexpr size_t kSimpleRadialK = 3;  // Index of a SIMPLE_RADIAL's radial coefficient.
// Bounds of the parameters: the logarithm of the focal length relative to the prior's, and the
// radial coefficient.
constexpr double kMaxLogFocal = 2.0;
constexpr double kMaxRadial = 0.5;

struct State {
  Rigid3d anchor_from_cam;
  double log_focal = 0.0;  // Relative to the prior's camera.
  double radial = 0.0;     // 0 without distortion, whatever the camera's coefficient.
};

using Linearization = NormalSystem<kNumParams>;

// The parts of the covariance at one state. Residuals are in standard deviations.
struct Spread {
  Matrix8d information = Matrix8d::Zero();  // Sum of J'J of the reprojections alone.
  Eigen::Matrix<double, kNumParams, 2> by_principal_point =
      Eigen::Matrix<double, kNumParams, 2>::Zero();  // Sum of J' times the principal point's.
  Vector8d by_distance = Vector8d::Zero();           // Sum of J'd, of ErrorShape::by_distance_px.
  ResidualSpread residuals;
};

double LongSidePx(const Camera& camera) { return std::max(camera.width_px(), camera.height_px()); }

struct Problem {
  const CameraPrior& prior;
  const std::vector<PoseObservation>& observations;
  const std::optional<GravityPrior>& gravity;
  const RefinePoseOptions& options;
  double prior_weight = 1.0;  // Weight of the camera's prior.

  ResidualWeights Weights() const { return {.keypoint_sigma_px = options.keypoint_sigma_px}; }

  Camera CameraOf(const State& state) const {
    const Camera scaled = WithFocalScaled(prior.camera, std::exp(state.log_focal));
    if (!prior.focal.with_distortion) {
      return scaled;
    }
    std::vector<double> params = scaled.params();
    params[kSimpleRadialK] = state.radial;
    return Camera(scaled.model(), scaled.width_px(), scaled.height_px(), std::move(params));
  }

  // Returns the Jacobian of the pixel of a landmark at `x_in_cam`.
  Jacobian8d PixelJacobian(const Camera& camera, const Eigen::Vector2d& pixel,
                           const Eigen::Matrix<double, 2, 3>& pixel_by_anchor,
                           const Eigen::Vector3d& from_center,
                           const Eigen::Vector3d& x_in_cam) const {
    Jacobian8d jacobian;
    jacobian.leftCols<6>() = ReprojectionJacobian(pixel_by_anchor, from_center);
    jacobian.col(kFocal) = pixel - PrincipalPointPx(camera);
    jacobian.col(kRadial).setZero();
    if (prior.focal.with_distortion) {
      const Eigen::Vector2d normalized = x_in_cam.hnormalized();
      jacobian.col(kRadial) = camera.focal_px() * normalized.squaredNorm() * normalized;
    }
    return jacobian;
  }

  // Calls visit(jacobian, residual_px, shape, information) for each observation that projects;
  // returns the number of those that do not. The first two are white by the shape.
  template <typename Visit>
  int ForEachProjected(const State& state, const Visit& visit) const {
    const Camera camera = CameraOf(state);
    const PosedCamera posed(camera, state.anchor_from_cam);
    int num_others = 0;
    Eigen::Matrix<double, 2, 3> pixel_by_anchor;
    for (const PoseObservation& observation : observations) {
      const auto pixel = ProjectLandmark(posed, observation.x_in_anchor, &pixel_by_anchor);
      if (!pixel) {
        ++num_others;
        continue;
      }
      const Eigen::Vector3d from_center = observation.x_in_anchor - posed.center_in_anchor;
      const Jacobian8d jacobian = PixelJacobian(camera, *pixel, pixel_by_anchor, from_center,
                                                posed.cam_from_anchor * from_center);
      const double landmark_px_m =
          observation.error_shape ? 0.0 : camera.focal_px() * observation.sigma_m;
      const ErrorShape shape = observation.error_shape.value_or(
          ErrorShape{Eigen::Matrix2d::Identity(), Eigen::Vector2d::Zero()});
      visit(Jacobian8d(shape.whitening * jacobian),
            Eigen::Vector2d(shape.whitening * (*pixel - observation.pixel)), shape,
            ReprojectionInformation(Weights(), landmark_px_m, from_center.squaredNorm()));
    }
    return num_others;
  }

  void AddPriors(const State& state, Linearization* system) const {
    if (gravity) {
      Eigen::Matrix<double, 3, 6> jacobian;
      const Eigen::Vector3d residual =
          GravityResidual(gravity->down_in_cam, state.anchor_from_cam, &jacobian);
      const double weight = 1.0 / (gravity->sigma_rad * gravity->sigma_rad);
      system->normal.topLeftCorner<6, 6>() += weight * jacobian.transpose() * jacobian;
      system->gradient.head<6>() += weight * jacobian.transpose() * residual;
      system->cost += 0.5 * weight * residual.squaredNorm();
    }
    const auto add = [&](int param, double value, double sigma) {
      const double weight = prior_weight / (sigma * sigma);
      system->normal(param, param) += weight;
      system->gradient[param] += weight * value;
      system->cost += 0.5 * weight * value * value;
    };
    add(kFocal, state.log_focal, prior.focal.log_sigma);
    add(kRadial, state.radial, prior.radial_sigma);
  }

  Linearization Linearize(const State& state) const {
    Linearization system;
    const ResidualWeights weights = Weights();
    const double sq_scale = kCauchyScale * kCauchyScale;
    const int num_gross =
        ForEachProjected(state, [&](const Jacobian8d& jacobian, const Eigen::Vector2d& residual,
                                    const ErrorShape& /*shape*/, double information) {
          const double sq_residual = information * residual.squaredNorm();
          const double weight = information * RobustWeight(weights, sq_residual);
          system.normal.noalias() += weight * jacobian.transpose() * jacobian;
          system.gradient.noalias() += weight * jacobian.transpose() * residual;
          system.cost += 0.5 * sq_scale * std::log1p(sq_residual / sq_scale);
        });
    system.cost += 0.5 * num_gross * sq_scale * std::log1p(kGrossError * kGrossError / sq_scale);
    AddPriors(state, &system);
    return system;
  }

  Spread SpreadAt(const State& state) const {
    const ResidualWeights weights = Weights();
    Spread spread;
    ForEachProjected(state, [&](const Jacobian8d& jacobian, const Eigen::Vector2d& residual,
                                const ErrorShape& shape, double information) {
      const double sq_residual = information * residual.squaredNorm();
      const double sq_robust = std::pow(RobustWeight(weights, sq_residual), 2);
      spread.information.noalias() += information * jacobian.transpose() * jacobian;
      // A principal point moves all pixels alike.
      spread.by_principal_point.noalias() += information * jacobian.transpose() * shape.whitening;
      spread.by_distance.noalias() += information * jacobian.transpose() * shape.by_distance_px;
      spread.residuals.sum_sq_weight += sq_robust;
      spread.residuals.sum_sq_weighted += sq_robust * sq_residual;
    });
    return spread;
  }

  double ScaleOf(const Spread& spread) const {
    return spread.residuals.CovarianceScale(static_cast<double>(observations.size()),
                                            kNumParams - 1);
  }

  // Returns the inverse of the information, in which reprojections are scaled by `scale`.
  Matrix8d Covariance(const State& state, const Spread& spread, double scale) const {
    Linearization priors;
    AddPriors(state, &priors);
    priors.normal.bottomRightCorner<2, 2>() /= prior_weight;
    Matrix8d total = spread.information / scale + priors.normal;
    total.diagonal().head<6>() += InformationFloor();
    const Matrix8d covariance = total.ldlt().solve(Matrix8d::Identity());
    return 0.5 * (covariance + covariance.transpose());
  }

  // Returns what a wrong principal point, and distances that err alike, add to a covariance. They
  // are not estimated, so their whole errors move the pose.
  Matrix8d ByCommonErrors(const Spread& spread, double scale, const Matrix8d& covariance) const {
    const double sigma_px = prior.principal_point_sigma * LongSidePx(prior.camera);
    Eigen::Matrix<double, kNumParams, 3> moved;
    moved << sigma_px * spread.by_principal_point, kCommonDistanceShare * spread.by_distance;
    moved = covariance * moved / scale;
    return moved * moved.transpose();
  }
};

State Moved(const State& state, const Vector8d& step) {
  State moved;
  moved.anchor_from_cam = PerturbPose(state.anchor_from_cam, step.head<6>());
  moved.log_focal = std::clamp(state.log_focal + step[kFocal], -kMaxLogFocal, kMaxLogFocal);
  moved.radial = std::clamp(state.radial + step[kRadial], -kMaxRadial, kMaxRadial);
  return moved;
}

State Minimize(const Problem& problem, const State& state) {
  const auto linearize = [&](const State& at) { return std::optional(problem.Linearize(at)); };
  const MinimizeOptions options = {.max_steps = 20,
                                   .min_damping = 1e-9,
                                   .diagonal_floor = 1e-9,
                                   .min_decrease = problem.options.min_relative_decrease};
  return MinimizeLeastSquares<kNumParams>(state, linearize, Moved, options)->state;
}

// Compares the prior with the observations. The prior has variance v about 0; prior and
// observations together have variance p about m. So the observations alone have variance p v / (v -
// p) about d = m v / (v - p). The prior and the observations differ by d, whose variance is v^2 /
// (v - p). The prior pulls the estimate by d - m = m p / (v - p).
//
// Returns the pull if they disagree, else 0.
double Judge(const CameraPrior& prior, double log_focal, double after, RefinedCamera* refined) {
  const double variance = prior.focal.log_sigma * prior.focal.log_sigma;
  const double learnt = variance - after;
  if (!(learnt > 1e-6 * variance)) {
    return 0.0;
  }
  refined->focal_disagreement = std::abs(log_focal) / std::sqrt(learnt);
  refined->focal_significance = std::abs(log_focal) * std::sqrt(variance / (after * learnt));
  return refined->FocalDisagrees() ? log_focal * after / learnt : 0.0;
}

// Adds the distance by which the prior pulls the focal length.
void AddPull(double pull, Matrix8d* covariance) {
  const Vector8d by_focal = covariance->col(kFocal) / (*covariance)(kFocal, kFocal);
  *covariance += pull * pull * by_focal * by_focal.transpose();
}

}  // namespace

RefinedCamera RefineCamera(const CameraPrior& prior, const Camera& initial_camera,
                           const std::vector<PoseObservation>& observations,
                           const std::optional<GravityPrior>& gravity,
                           const Rigid3d& initial_cam_from_anchor,
                           const RefinePoseOptions& options) {
  Problem problem{prior, observations, gravity, options};
  State state;
  state.anchor_from_cam = initial_cam_from_anchor.Inverse();
  state.log_focal = std::log(initial_camera.focal_px() / prior.camera.focal_px());
  state.radial = prior.focal.with_distortion ? initial_camera.params()[kSimpleRadialK] : 0.0;
  state = Minimize(problem, state);
  Spread spread = problem.SpreadAt(state);
  problem.prior_weight = std::max(1.0, problem.ScaleOf(spread));
  if (problem.prior_weight > 1.0) {
    state = Minimize(problem, state);
    spread = problem.SpreadAt(state);
  }
  RefinedCamera refined;
  refined.camera = problem.CameraOf(state);
  refined.cam_from_anchor = state.anchor_from_cam.Inverse();
  // What the observations say of the focal length is judged with their stated errors at least:
  // systematic errors of the map would contradict every camera.
  const double scale = problem.ScaleOf(spread);
  Matrix8d judged = problem.Covariance(state, spread, std::max(1.0, scale));
  const double pull = Judge(prior, state.log_focal, judged(kFocal, kFocal), &refined);
  AddPull(pull, &judged);
  refined.focal_log_sigma = std::sqrt(judged(kFocal, kFocal));
  Matrix8d covariance = problem.Covariance(state, spread, scale);
  covariance += problem.ByCommonErrors(spread, scale, covariance);
  AddPull(pull, &covariance);
  refined.covariance = covariance.topLeftCorner<6, 6>();
  return refined;
}

}  // namespace cairn
