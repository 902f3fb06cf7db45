#include "engine/pose/refine_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "engine/pose/pose_residuals.h"

namespace cairn {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Residual of an observation that does not project, in standard deviations.
constexpr double kGrossError = 100.0;

// The normal equations at one pose.
struct Linearization {
  Matrix6d normal = Matrix6d::Zero();          // Sum of w J'J, with the gravity prior.
  PoseTangent gradient = PoseTangent::Zero();  // Sum of w J'r, with the gravity prior.
  double cost = 0.0;
};

// What the covariance at one pose is made of. Residuals r are in standard deviations, w is their
// robust weight.
struct Spread {
  Matrix6d information = Matrix6d::Zero();          // Sum of J'J of the reprojections alone.
  Matrix6d gravity_information = Matrix6d::Zero();  // J'J of the gravity prior.
  double sum_sq_weight = 0.0;                       // Sum of w^2.
  double sum_sq_weighted = 0.0;                     // Sum of w^2 r'r.
};

// Sums the Cauchy losses of squared residuals in standard deviations.
class CauchyCost {
 public:
  explicit CauchyCost(double scale) : sq_scale_(scale * scale) {}

  void Add(double sq_residual) {
    // A sum of logarithms is the logarithm of a product: one call for many residuals.
    product_ *= 1.0 + sq_residual / sq_scale_;
    if (product_ > 1e200) {
      Flush();
    }
  }

  // Half the sum.
  double Total() {
    Flush();
    return 0.5 * sq_scale_ * sum_of_logs_;
  }

 private:
  void Flush() {
    sum_of_logs_ += std::log(product_);
    product_ = 1.0;
  }

  double sq_scale_;
  double product_ = 1.0;
  double sum_of_logs_ = 0.0;
};

// The problem in the form the iterations need.
struct Problem {
  const Camera& camera;
  const std::vector<PoseObservation>& observations;
  const std::optional<GravityPrior>& gravity;
  const RefinePoseOptions& options;
  std::span<const QueryRigCamera> other_cameras;

  const Camera& CameraOf(const PoseObservation& observation) const {
    return observation.camera_idx == 0 ? camera : other_cameras[observation.camera_idx - 1].camera;
  }

  // ReprojectionResidual in the camera that made the observation, its Jacobian by the rig's pose.
  std::optional<Eigen::Vector2d> Residual(const PoseObservation& observation,
                                          const Rigid3d& anchor_from_cam,
                                          Eigen::Matrix<double, 2, 6>* jacobian) const {
    if (observation.camera_idx == 0) {
      return ReprojectionResidual(camera, observation.pixel, observation.x_in_anchor,
                                  anchor_from_cam, jacobian);
    }
    const QueryRigCamera& own = other_cameras[observation.camera_idx - 1];
    const Rigid3d anchor_from_own = anchor_from_cam * own.cam_from_first.Inverse();
    const auto residual = ReprojectionResidual(own.camera, observation.pixel,
                                               observation.x_in_anchor, anchor_from_own, jacobian);
    // A rotation about the first camera moves this one by rotation x offset.
    const Eigen::Vector3d offset = anchor_from_own.translation - anchor_from_cam.translation;
    if (residual) {
      jacobian->leftCols<3>() -= jacobian->rightCols<3>() * Skew(offset);
    }
    return residual;
  }

  double Information(const PoseObservation& observation, const Rigid3d& anchor_from_cam) const {
    const double distance_m =
        std::max(1e-3, (observation.x_in_anchor - anchor_from_cam.translation).norm());
    const double landmark_px = CameraOf(observation).focal_px() * observation.sigma_m / distance_m;
    return 1.0 /
           (options.keypoint_sigma_px * options.keypoint_sigma_px + landmark_px * landmark_px);
  }

  double RobustWeight(double sq_residual) const {
    return 1.0 / (1.0 + sq_residual / (options.cauchy_scale * options.cauchy_scale));
  }

  Linearization Linearize(const Rigid3d& anchor_from_cam) const {
    Linearization system;
    CauchyCost cost(options.cauchy_scale);
    Eigen::Matrix<double, 2, 6> jacobian;
    for (const PoseObservation& observation : observations) {
      const auto residual = Residual(observation, anchor_from_cam, &jacobian);
      if (!residual) {
        cost.Add(kGrossError * kGrossError);
        continue;
      }
      const double information = Information(observation, anchor_from_cam);
      const double sq_residual = residual->squaredNorm() * information;
      const Eigen::Matrix<double, 6, 2> weighted =
          RobustWeight(sq_residual) * information * jacobian.transpose();
      system.normal.noalias() += weighted * jacobian;
      system.gradient.noalias() += weighted * *residual;
      cost.Add(sq_residual);
    }
    system.cost = cost.Total();
    if (gravity) {
      Eigen::Matrix<double, 3, 6> gravity_jacobian;
      const Eigen::Vector3d residual =
          GravityResidual(gravity->down_in_cam, anchor_from_cam, &gravity_jacobian);
      const double weight = 1.0 / (gravity->sigma_rad * gravity->sigma_rad);
      system.normal += weight * gravity_jacobian.transpose() * gravity_jacobian;
      system.gradient.noalias() += weight * gravity_jacobian.transpose() * residual;
      system.cost += 0.5 * weight * residual.squaredNorm();
    }
    return system;
  }

  Spread SpreadAt(const Rigid3d& anchor_from_cam) const {
    Spread spread;
    Eigen::Matrix<double, 2, 6> jacobian;
    for (const PoseObservation& observation : observations) {
      if (const auto residual = Residual(observation, anchor_from_cam, &jacobian)) {
        const double information = Information(observation, anchor_from_cam);
        const double sq_residual = residual->squaredNorm() * information;
        const double sq_robust = std::pow(RobustWeight(sq_residual), 2);
        spread.information += information * jacobian.transpose() * jacobian;
        spread.sum_sq_weight += sq_robust;
        spread.sum_sq_weighted += sq_robust * sq_residual;
      }
    }
    if (gravity) {
      Eigen::Matrix<double, 3, 6> gravity_jacobian;
      GravityResidual(gravity->down_in_cam, anchor_from_cam, &gravity_jacobian);
      spread.gravity_information = gravity_jacobian.transpose() * gravity_jacobian /
                                   (gravity->sigma_rad * gravity->sigma_rad);
    }
    return spread;
  }
};

// Asymptotic covariance of the M-estimate (Huber 1981, section 7.6): the inverse information of the
// reprojections is scaled by mean(psi^2) / mean(psi')^2. For the Cauchy loss on two-dimensional
// residuals psi = w r and psi' averages to w^2. A floor keeps free directions finite.
Matrix6d Covariance(const Spread& spread, double num_observations) {
  PoseTangent floor;
  floor << Eigen::Vector3d::Constant(1.0 / 9.0), Eigen::Vector3d::Constant(1e-6);
  double scale = 1.0;
  if (spread.sum_sq_weight > 0.0) {
    const double degrees_of_freedom = std::max(1.0, 2.0 * num_observations - 6.0);
    const double mean_slope = spread.sum_sq_weight / num_observations;
    scale = std::max(1.0, spread.sum_sq_weighted / degrees_of_freedom / (mean_slope * mean_slope));
  }
  const Matrix6d total =
      spread.information / scale + spread.gravity_information + Matrix6d(floor.asDiagonal());
  const Matrix6d covariance = total.ldlt().solve(Matrix6d::Identity());
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace

RefinedPose RefinePose(const Camera& camera, const std::vector<PoseObservation>& observations,
                       const std::optional<GravityPrior>& gravity,
                       const Rigid3d& initial_cam_from_anchor, const RefinePoseOptions& options,
                       std::span<const QueryRigCamera> other_cameras) {
  constexpr double kMaxDamping = 1e6;
  const Problem problem{camera, observations, gravity, options, other_cameras};
  Rigid3d anchor_from_cam = initial_cam_from_anchor.Inverse();
  Linearization system = problem.Linearize(anchor_from_cam);
  RefinedPose refined;
  double damping = 1e-4;  // Relative to the diagonal of the normal matrix.
  for (int i = 0; i < options.max_iterations && damping < kMaxDamping; ++i) {
    Matrix6d damped = system.normal;
    damped.diagonal() *= 1.0 + damping;
    damped.diagonal().array() += 1e-9;
    const Rigid3d moved = PerturbPose(anchor_from_cam, -damped.ldlt().solve(system.gradient));
    const Linearization moved_system = problem.Linearize(moved);
    if (!(moved_system.cost < system.cost)) {
      damping *= 10.0;
      continue;
    }
    const double decrease = system.cost - moved_system.cost;
    anchor_from_cam = moved;
    system = moved_system;
    damping = std::max(1e-9, damping * 0.1);
    ++refined.num_iterations;
    if (decrease < options.min_relative_decrease * system.cost) {
      break;
    }
  }
  refined.cam_from_anchor = anchor_from_cam.Inverse();
  refined.cost = system.cost;
  if (options.with_covariance) {
    refined.covariance =
        Covariance(problem.SpreadAt(anchor_from_cam), static_cast<double>(observations.size()));
  }
  return refined;
}

}  // namespace cairn
