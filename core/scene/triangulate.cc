#include "core/scene/triangulate.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/least_squares.h"
#include "core/statistics.h"

namespace cairn {
namespace {

constexpr int kMaxSteps = 30;
// Scale of Cauchy's loss, in standard deviations of a pixel.
constexpr double kLossScaleSigmas = 2.0;
// Smallest ratio of the smallest to the largest eigenvalue of a solvable system. Rays that span an
// angle of 1e-4 radians give 1e-8.
constexpr double kMinConditioning = 1e-9;

bool IsSolvable(const Eigen::Matrix3d& hessian) {
  const Eigen::Vector3d eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(hessian, Eigen::EigenvaluesOnly).eigenvalues();
  return eigenvalues[0] > kMinConditioning * eigenvalues[2];
}

// The point with the smallest sum of squared distances to all rays.
std::optional<Eigen::Vector3d> NearestToRays(std::span<const PointObservation> observations) {
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d rhs = Eigen::Vector3d::Zero();
  for (const PointObservation& observation : observations) {
    const auto ray_in_cam = observation.camera->Unproject(observation.pixel);
    if (!ray_in_cam) {
      return std::nullopt;
    }
    const Rigid3d world_from_cam = observation.cam_from_world.Inverse();
    const Eigen::Vector3d ray = world_from_cam.rotation * *ray_in_cam;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    hessian += across;
    rhs += across * world_from_cam.translation;
  }
  if (!IsSolvable(hessian)) {
    return std::nullopt;
  }
  return hessian.ldlt().solve(rhs);
}

// Normal equations of the reprojection errors in units of their sigmas. Returns nothing if the
// point is not visible in an observation. `robust` applies Cauchy's loss.
std::optional<NormalSystem<3>> Linearize(std::span<const PointObservation> observations,
                                         const Eigen::Vector3d& x_in_world, bool robust) {
  constexpr double kSqLossScale = kLossScaleSigmas * kLossScaleSigmas;
  NormalSystem<3> equations;
  for (const PointObservation& observation : observations) {
    Eigen::Matrix<double, 2, 3> pixel_by_cam;
    const auto pixel = observation.camera->ProjectWithJacobian(
        observation.cam_from_world * x_in_world, &pixel_by_cam);
    if (!pixel) {
      return std::nullopt;
    }
    const Eigen::Vector2d residual = (*pixel - observation.pixel) / observation.sigma_px;
    const Eigen::Matrix<double, 2, 3> jacobian =
        pixel_by_cam * observation.cam_from_world.rotation.toRotationMatrix() /
        observation.sigma_px;
    const double sq_residual = residual.squaredNorm();
    const double weight = robust ? 1.0 / (1.0 + sq_residual / kSqLossScale) : 1.0;
    equations.normal += weight * jacobian.transpose() * jacobian;
    equations.gradient += weight * jacobian.transpose() * residual;
    equations.cost += robust ? kSqLossScale * std::log1p(sq_residual / kSqLossScale) : sq_residual;
  }
  return equations;
}

}  // namespace

double KeypointSigmaPx(double scale_px) { return std::max(0.5, 0.2 * scale_px); }

std::vector<PointObservation> PointObservationsOf(const Reconstruction& reconstruction,
                                                  const ReconLandmark& landmark) {
  std::vector<PointObservation> observations;
  observations.reserve(landmark.observations.size());
  for (const ReconObservation& observation : landmark.observations) {
    const ReconImage& image = reconstruction.images[observation.image_idx];
    const Keypoint& keypoint = image.features.keypoints[observation.keypoint_idx];
    observations.push_back({&reconstruction.cameras[image.camera_idx], image.cam_from_world,
                            Eigen::Vector2d(keypoint.x_px, keypoint.y_px),
                            KeypointSigmaPx(keypoint.scale_px)});
  }
  return observations;
}

std::optional<Eigen::Vector3d> TriangulatePoint(std::span<const PointObservation> observations) {
  if (observations.size() < 2) {
    return std::nullopt;
  }
  const std::optional<Eigen::Vector3d> x_in_world = NearestToRays(observations);
  if (!x_in_world) {
    return std::nullopt;
  }
  const auto minimum = MinimizeLeastSquares<3>(
      *x_in_world,
      [&](const Eigen::Vector3d& x) { return Linearize(observations, x, /*robust=*/true); },
      [](const Eigen::Vector3d& x, const Eigen::Vector3d& step) {
        return Eigen::Vector3d(x + step);
      },
      {.max_steps = kMaxSteps, .min_decrease = 1e-9});
  return minimum ? std::optional(minimum->state) : std::nullopt;
}

double PointUncertainty::Sigma() const { return std::sqrt(covariance.trace() / 3.0); }

std::optional<PointUncertainty> EstimateUncertainty(std::span<const PointObservation> observations,
                                                    const Eigen::Vector3d& x_in_world) {
  const auto equations = Linearize(observations, x_in_world, /*robust=*/false);
  if (observations.size() < 2 || !equations || !IsSolvable(equations->normal)) {
    return std::nullopt;
  }
  const double degrees_of_freedom = 2.0 * observations.size() - 3.0;
  const double disagreement = std::max(1.0, equations->cost / degrees_of_freedom);

  std::vector<double> errors_px;
  for (const PointObservation& observation : observations) {
    errors_px.push_back(
        (*observation.camera->Project(observation.cam_from_world * x_in_world) - observation.pixel)
            .norm());
  }
  return PointUncertainty{disagreement * equations->normal.inverse(), Median(std::move(errors_px))};
}

}  // namespace cairn
