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

// Six parameters of the pose, the logarithm of the focal length, the radial coefficient, the
// logarithm of fx / fy, the principal point.
constexpr int kNumParams = 11;
constexpr int kFocal = 6, kRadial = 7, kAspect = 8, kPrincipalPoint = 9;
using ParamVector = Eigen::Matrix<double, kNumParams, 1>;
using ParamMatrix = Eigen::Matrix<double, kNumParams, kNumParams>;
using ParamJacobian = Eigen::Matrix<double, 2, kNumParams>;

// Bounds of the parameters: the logarithm of the focal length relative to the prior's, the radial
// coefficient, and the logarithm of fx / fy.
constexpr double kMaxLogFocal = 2.0;
constexpr double kMaxRadial = 0.5;
constexpr double kMaxAspect = 0.1;
// Of the principal point: how far it may be from the prior's, in units of the image's long side.
constexpr double kMaxShift = 1.0;

struct State {
  Rigid3d anchor_from_cam;
  double log_focal = 0.0;  // Relative to the prior's camera.
  double radial = 0.0;     // 0 without distortion, whatever the camera's coefficient.
  double aspect = 0.0;     // Relative to the prior's camera.
  // From the prior's principal point, in units of the image's long side.
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
};

using Linearization = NormalSystem<kNumParams>;

// The parts of the covariance at one state. Residuals are in standard deviations.
struct Spread {
  ParamMatrix information = ParamMatrix::Zero();  // Sum of J'J of the reprojections alone.
  ParamVector by_distance = ParamVector::Zero();  // Sum of J'd, of ErrorShape::by_distance_px.
  ResidualSpread residuals;
};

double LongSidePx(const Camera& camera) { return std::max(camera.width_px(), camera.height_px()); }

// Index of the radial coefficient of a SIMPLE_RADIAL camera, also in another model.
size_t RadialIdx(const Camera& camera) {
  return static_cast<size_t>(NumFocalLengths(camera.model())) + 2;
}

struct Problem {
  Problem(const CameraPrior& camera_prior, const std::vector<PoseObservation>& seen,
          const std::optional<GravityPrior>& gravity_prior, const RefinePoseOptions& how)
      : prior(camera_prior),
        observations(seen),
        gravity(gravity_prior),
        options(how),
        camera(prior.principal_point_sigma > 0.0 ? WithTwoFocalLengths(prior.camera)
                                                 : prior.camera),
        has_known_pixels(prior.principal_point_sigma == 0.0 ||
                         NumFocalLengths(camera.model()) < 2) {}

  const CameraPrior& prior;
  const std::vector<PoseObservation>& observations;
  const std::optional<GravityPrior>& gravity;
  const RefinePoseOptions& options;
  const Camera camera;          // The prior's, in a model that has all of the unknowns.
  const bool has_known_pixels;  // The principal point and the shape of pixels are known.
  double prior_weight = 1.0;    // Weight of the camera's prior.

  ResidualWeights Weights() const { return {.keypoint_sigma_px = options.keypoint_sigma_px}; }

  Camera CameraOf(const State& state) const {
    std::vector<double> params = camera.params();
    const int num_focal_lengths = NumFocalLengths(camera.model());
    for (int i = 0; i < num_focal_lengths; ++i) {
      params[i] *= std::exp(state.log_focal);
    }
    if (!has_known_pixels) {
      params[0] *= std::exp(0.5 * state.aspect);
      params[1] *= std::exp(-0.5 * state.aspect);
      params[num_focal_lengths] += LongSidePx(camera) * state.shift.x();
      params[num_focal_lengths + 1] += LongSidePx(camera) * state.shift.y();
    }
    if (prior.focal.with_distortion) {
      params[RadialIdx(camera)] = state.radial;
    }
    return Camera(camera.model(), camera.width_px(), camera.height_px(), std::move(params));
  }

  // Returns the Jacobian of the pixel of a landmark at `x_in_cam`.
  ParamJacobian PixelJacobian(const Camera& at, const Eigen::Vector2d& pixel,
                              const Eigen::Matrix<double, 2, 3>& pixel_by_anchor,
                              const Eigen::Vector3d& from_center,
                              const Eigen::Vector3d& x_in_cam) const {
    ParamJacobian jacobian;
    jacobian.leftCols<6>() = ReprojectionJacobian(pixel_by_anchor, from_center);
    jacobian.col(kFocal) = pixel - PrincipalPointPx(at);
    jacobian.rightCols<4>().setZero();
    if (!has_known_pixels) {
      jacobian.col(kAspect) = 0.5 * jacobian.col(kFocal).cwiseProduct(Eigen::Vector2d(1.0, -1.0));
      jacobian.rightCols<2>().diagonal().setConstant(LongSidePx(at));
    }
    if (prior.focal.with_distortion) {
      const Eigen::Vector2d normalized = x_in_cam.hnormalized();
      jacobian.col(kRadial) = at.focal_px() * normalized.squaredNorm() * normalized;
    }
    return jacobian;
  }

  // Calls visit(jacobian, residual_px, shape, information) for each observation that projects;
  // returns the number of those that do not. The first two are white by the shape.
  template <typename Visit>
  int ForEachProjected(const State& state, const Visit& visit) const {
    const Camera at = CameraOf(state);
    const PosedCamera posed(at, state.anchor_from_cam);
    int num_others = 0;
    Eigen::Matrix<double, 2, 3> pixel_by_anchor;
    for (const PoseObservation& observation : observations) {
      const auto pixel = ProjectLandmark(posed, observation.x_in_anchor, &pixel_by_anchor);
      if (!pixel) {
        ++num_others;
        continue;
      }
      const Eigen::Vector3d from_center = observation.x_in_anchor - posed.center_in_anchor;
      const ParamJacobian jacobian = PixelJacobian(at, *pixel, pixel_by_anchor, from_center,
                                                   posed.cam_from_anchor * from_center);
      const double landmark_px_m =
          observation.error_shape ? 0.0 : at.focal_px() * observation.sigma_m;
      const ErrorShape shape = observation.error_shape.value_or(
          ErrorShape{Eigen::Matrix2d::Identity(), Eigen::Vector2d::Zero()});
      visit(ParamJacobian(shape.whitening * jacobian),
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
    add(kAspect, state.aspect, prior.aspect_sigma);
    for (int axis = 0; axis < 2; ++axis) {
      add(kPrincipalPoint + axis, state.shift[axis],
          has_known_pixels ? 1.0 : prior.principal_point_sigma);
    }
  }

  Linearization Linearize(const State& state) const {
    Linearization system;
    const ResidualWeights weights = Weights();
    const double sq_scale = kCauchyScale * kCauchyScale;
    const int num_gross =
        ForEachProjected(state, [&](const ParamJacobian& jacobian, const Eigen::Vector2d& residual,
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
    ForEachProjected(state, [&](const ParamJacobian& jacobian, const Eigen::Vector2d& residual,
                                const ErrorShape& shape, double information) {
      const double sq_residual = information * residual.squaredNorm();
      const double sq_robust = std::pow(RobustWeight(weights, sq_residual), 2);
      spread.information.noalias() += information * jacobian.transpose() * jacobian;
      spread.by_distance.noalias() += information * jacobian.transpose() * shape.by_distance_px;
      spread.residuals.sum_sq_weight += sq_robust;
      spread.residuals.sum_sq_weighted += sq_robust * sq_residual;
    });
    return spread;
  }

  double ScaleOf(const Spread& spread) const {
    // The radial coefficient is hardly free.
    const int num_free = has_known_pixels ? kFocal + 1 : kNumParams - 1;
    return spread.residuals.CovarianceScale(static_cast<double>(observations.size()), num_free);
  }

  // Returns the inverse of the information, in which reprojections are scaled by `scale`.
  ParamMatrix Covariance(const State& state, const Spread& spread, double scale) const {
    Linearization priors;
    AddPriors(state, &priors);
    priors.normal.bottomRightCorner<5, 5>() /= prior_weight;
    ParamMatrix total = spread.information / scale + priors.normal;
    total.diagonal().head<6>() += InformationFloor();
    const ParamMatrix covariance = total.ldlt().solve(ParamMatrix::Identity());
    return 0.5 * (covariance + covariance.transpose());
  }
};

// Returns what distances that err alike add to a covariance. They are not estimated, so their whole
// errors move the pose.
ParamMatrix ByCommonErrors(const Spread& spread, double scale, const ParamMatrix& covariance) {
  const ParamVector moved = kCommonDistanceShare * (covariance * spread.by_distance) / scale;
  return moved * moved.transpose();
}

double LogAspect(const Camera& camera) {
  const bool has_two = NumFocalLengths(camera.model()) == 2;
  return has_two ? std::log(camera.params()[0] / camera.params()[1]) : 0.0;
}

State StateOf(const CameraPrior& prior, const Camera& camera, const Rigid3d& cam_from_anchor) {
  State state;
  state.anchor_from_cam = cam_from_anchor.Inverse();
  state.log_focal = std::log(camera.focal_px() / prior.camera.focal_px());
  state.radial = prior.focal.with_distortion ? camera.params()[RadialIdx(camera)] : 0.0;
  state.aspect = LogAspect(camera) - LogAspect(prior.camera);
  state.shift = (PrincipalPointPx(camera) - PrincipalPointPx(prior.camera)) / LongSidePx(camera);
  return state;
}

State Moved(const State& state, const ParamVector& step) {
  State moved;
  moved.anchor_from_cam = PerturbPose(state.anchor_from_cam, step.head<6>());
  moved.log_focal = std::clamp(state.log_focal + step[kFocal], -kMaxLogFocal, kMaxLogFocal);
  moved.radial = std::clamp(state.radial + step[kRadial], -kMaxRadial, kMaxRadial);
  moved.aspect = std::clamp(state.aspect + step[kAspect], -kMaxAspect, kMaxAspect);
  moved.shift = (state.shift + step.tail<2>()).cwiseMax(-kMaxShift).cwiseMin(kMaxShift);
  return moved;
}

State Minimize(const Problem& problem, const State& state) {
  const auto linearize = [&](const State& at) { return std::optional(problem.Linearize(at)); };
  // Camera and pose trade off against each other, so the cost falls slowly before it has settled.
  constexpr double kMinDecrease = 1e-7;
  const MinimizeOptions options = {
      .max_steps = 40, .min_damping = 1e-9, .diagonal_floor = 1e-9, .min_decrease = kMinDecrease};
  return MinimizeLeastSquares<kNumParams>(state, linearize, Moved, options)->state;
}

// What prior and observations say of one parameter, whose prior has mean 0.
struct Comparison {
  double disagreement = 0.0, significance = 0.0;  // As in RefinedCamera.
  double pull = 0.0;                              // By which the prior moves the estimate.
};

// The prior has variance v about 0; prior and observations together have variance p about m. So the
// observations alone have variance p v / (v - p) about d = m v / (v - p). The prior and the
// observations differ by d, whose variance is v^2 / (v - p). The prior pulls the estimate by d - m
// = m p / (v - p).
Comparison Compare(double sigma, double estimate, double after) {
  const double variance = sigma * sigma;
  const double learnt = variance - after;
  if (!(learnt > 1e-6 * variance)) {
    return {};
  }
  return {std::abs(estimate) / std::sqrt(learnt),
          std::abs(estimate) * std::sqrt(variance / (after * learnt)), estimate * after / learnt};
}

// Returns the pull on the focal length if it disagrees, else 0.
double Judge(const CameraPrior& prior, const State& state, const ParamMatrix& covariance,
             RefinedCamera* refined) {
  const Comparison focal =
      Compare(prior.focal.log_sigma, state.log_focal, covariance(kFocal, kFocal));
  refined->focal_disagreement = focal.disagreement;
  refined->focal_significance = focal.significance;
  for (int axis = 0; axis < 2; ++axis) {
    const int param = kPrincipalPoint + axis;
    refined->principal_point_disagreement =
        std::max(refined->principal_point_disagreement,
                 Compare(prior.principal_point_sigma, state.shift[axis], covariance(param, param))
                     .disagreement);
  }
  return refined->FocalDisagrees() ? focal.pull : 0.0;
}

// Adds the distance by which the prior pulls the focal length.
void AddPull(double pull, ParamMatrix* covariance) {
  const ParamVector by_focal = covariance->col(kFocal) / (*covariance)(kFocal, kFocal);
  *covariance += pull * pull * by_focal * by_focal.transpose();
}

}  // namespace

RefinedCamera RefineCamera(const CameraPrior& prior, const Camera& initial_camera,
                           const std::vector<PoseObservation>& observations,
                           const std::optional<GravityPrior>& gravity,
                           const Rigid3d& initial_cam_from_anchor,
                           const RefinePoseOptions& options) {
  Problem problem(prior, observations, gravity, options);
  State state = Minimize(problem, StateOf(prior, initial_camera, initial_cam_from_anchor));
  Spread spread = problem.SpreadAt(state);
  problem.prior_weight = std::max(1.0, problem.ScaleOf(spread));
  if (problem.prior_weight > 1.0) {
    state = Minimize(problem, state);
    spread = problem.SpreadAt(state);
  }
  RefinedCamera refined;
  refined.camera = problem.CameraOf(state);
  refined.is_off_center = prior.is_off_center;
  refined.cam_from_anchor = state.anchor_from_cam.Inverse();
  // What the observations say of the focal length is judged with their stated errors at least:
  // systematic errors of the map would contradict every camera.
  const double scale = problem.ScaleOf(spread);
  ParamMatrix judged = problem.Covariance(state, spread, std::max(1.0, scale));
  const double pull = Judge(prior, state, judged, &refined);
  AddPull(pull, &judged);
  refined.focal_log_sigma = std::sqrt(judged(kFocal, kFocal));
  if (!problem.has_known_pixels) {
    refined.principal_point_sigma_px =
        LongSidePx(prior.camera) * std::sqrt(judged.diagonal().tail<2>().maxCoeff());
  }
  ParamMatrix covariance = problem.Covariance(state, spread, scale);
  covariance += ByCommonErrors(spread, scale, covariance);
  AddPull(pull, &covariance);
  refined.covariance = covariance.topLeftCorner<6, 6>();
  return refined;
}

}  // namespace cairn
