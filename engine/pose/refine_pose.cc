#include "engine/pose/refine_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/least_squares.h"
#include "engine/pose/m_estimate.h"
#include "engine/pose/normal_equations.h"
#include "engine/pose/pose_residuals.h"

namespace cairn {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

// The parts of the covariance at one pose. Residuals are in standard deviations.
struct Spread {
  Matrix6d information = Matrix6d::Zero();          // Sum of J'J of the reprojections alone.
  Matrix6d gravity_information = Matrix6d::Zero();  // J'J of the gravity prior.
  PoseTangent by_distance = PoseTangent::Zero();    // Sum of J'd, of ErrorShape::by_distance_px.
  ResidualSpread residuals;
};

// The problem in the form that the iterations need.
struct Problem {
  const Camera& camera;
  const std::vector<PoseObservation>& observations;
  const std::optional<GravityPrior>& gravity;
  const RefinePoseOptions& options;
  std::span<const QueryRigCamera> other_cameras;

  ResidualWeights Weights() const { return {.keypoint_sigma_px = options.keypoint_sigma_px}; }

  // Calls visit(observation, pixel_by_anchor, from_center, residual_px, landmark_px_m) for each
  // observation that projects; the last four are the arguments of NormalEquations::Add. Returns the
  // number of those that do not.
  template <typename Visit>
  int ForEachProjected(const Rigid3d& anchor_from_cam, const Visit& visit) const {
    const PosedCamera first(camera, anchor_from_cam);
    std::vector<PosedCamera> others;
    for (const QueryRigCamera& other : other_cameras) {
      others.emplace_back(other.camera, anchor_from_cam * other.cam_from_first.Inverse());
    }
    int num_others = 0;
    Eigen::Matrix<double, 2, 3> pixel_by_anchor;
    for (const PoseObservation& observation : observations) {
      const PosedCamera& own =
          observation.camera_idx == 0 ? first : others[observation.camera_idx - 1];
      const auto pixel = ProjectLandmark(own, observation.x_in_anchor, &pixel_by_anchor);
      if (!pixel) {
        ++num_others;
        continue;
      }
      const Eigen::Vector3d from_center = observation.x_in_anchor - first.center_in_anchor;
      const Eigen::Vector2d residual_px = *pixel - observation.pixel;
      if (observation.error_shape) {
        const Eigen::Matrix2d& whitening = observation.error_shape->whitening;
        visit(observation, whitening * pixel_by_anchor, from_center, whitening * residual_px, 0.0);
      } else {
        visit(observation, pixel_by_anchor, from_center, residual_px,
              own.camera->focal_px() * observation.sigma_m);
      }
    }
    return num_others;
  }

  // With the gravity prior.
  NormalSystem<6> Linearize(const Rigid3d& anchor_from_cam) const {
    NormalEquations equations(Weights());
    const int num_gross = ForEachProjected(
        anchor_from_cam, [&](const PoseObservation& /*observation*/, const auto&... projected) {
          equations.Add(projected...);
        });
    const NormalEquations::Sums sums = equations.Finish();
    NormalSystem<6> system = {sums.normal, sums.gradient, sums.cost};
    const double sq_scale = kCauchyScale * kCauchyScale;
    system.cost += 0.5 * num_gross * sq_scale * std::log1p(kGrossError * kGrossError / sq_scale);
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
    const ResidualWeights weights = Weights();
    ForEachProjected(anchor_from_cam, [&](const PoseObservation& observation,
                                          const Eigen::Matrix<double, 2, 3>& pixel_by_anchor,
                                          const Eigen::Vector3d& from_center,
                                          const Eigen::Vector2d& residual, double landmark_px_m) {
      const double information =
          ReprojectionInformation(weights, landmark_px_m, from_center.squaredNorm());
      const double sq_residual = residual.squaredNorm() * information;
      const double sq_robust = std::pow(RobustWeight(weights, sq_residual), 2);
      const auto jacobian = ReprojectionJacobian(pixel_by_anchor, from_center);
      spread.information += information * jacobian.transpose() * jacobian;
      if (observation.error_shape) {
        spread.by_distance +=
            information * jacobian.transpose() * observation.error_shape->by_distance_px;
      }
      spread.residuals.sum_sq_weight += sq_robust;
      spread.residuals.sum_sq_weighted += sq_robust * sq_residual;
    });
    if (gravity) {
      Eigen::Matrix<double, 3, 6> gravity_jacobian;
      GravityResidual(gravity->down_in_cam, anchor_from_cam, &gravity_jacobian);
      spread.gravity_information = gravity_jacobian.transpose() * gravity_jacobian /
                                   (gravity->sigma_rad * gravity->sigma_rad);
    }
    return spread;
  }
};

Matrix6d Covariance(const Spread& spread, double num_observations) {
  const double scale = spread.residuals.CovarianceScale(num_observations, 6);
  const Matrix6d total = spread.information / scale + spread.gravity_information +
                         Matrix6d(InformationFloor().asDiagonal());
  const Matrix6d covariance = total.ldlt().solve(Matrix6d::Identity());
  const PoseTangent by_distance = kCommonDistanceShare / scale * covariance * spread.by_distance;
  return 0.5 * (covariance + covariance.transpose()) + by_distance * by_distance.transpose();
}

}  // namespace

RefinedPose RefinePose(const Camera& camera, const std::vector<PoseObservation>& observations,
                       const std::optional<GravityPrior>& gravity,
                       const Rigid3d& initial_cam_from_anchor, const RefinePoseOptions& options,
                       std::span<const QueryRigCamera> other_cameras) {
  const Problem problem{camera, observations, gravity, options, other_cameras};
  const auto minimum =
      *MinimizeLeastSquares<6>(initial_cam_from_anchor.Inverse(),
                               [&](const Rigid3d& anchor_from_cam) {
                                 return std::optional(problem.Linearize(anchor_from_cam));
                               },
                               PerturbPose,
                               {.max_steps = options.max_iterations,
                                .min_damping = 1e-9,
                                .diagonal_floor = 1e-9,
                                .min_decrease = options.min_relative_decrease});
  RefinedPose refined;
  refined.cam_from_anchor = minimum.state.Inverse();
  refined.cost = minimum.system.cost;
  refined.num_iterations = minimum.num_steps;
  return refined;
}

Eigen::Matrix<double, 6, 6> PoseCovariance(const Camera& camera,
                                           const std::vector<PoseObservation>& observations,
                                           const std::optional<GravityPrior>& gravity,
                                           const Rigid3d& cam_from_anchor,
                                           const RefinePoseOptions& options,
                                           std::span<const QueryRigCamera> other_cameras) {
  const Problem problem{camera, observations, gravity, options, other_cameras};
  return Covariance(problem.SpreadAt(cam_from_anchor.Inverse()),
                    static_cast<double>(observations.size()));
}

}  // namespace cairn
