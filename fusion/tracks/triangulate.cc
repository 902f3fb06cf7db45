#include "fusion/tracks/triangulate.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/least_squares.h"
#include "core/require.h"

namespace cairn::fusion {
namespace {

// Largest standard deviation of the depth relative to the depth. Above this limit the depth's error
// is not Gaussian, and a filter that linearizes at such points becomes overconfident, in yaw first.
// A lower limit leaves out far points that tell the rotation. The value was measured with
// cairn_fusion_consistency; see docs/math/fusion.md.
constexpr double kMaxRelativeDepthSigma = 0.12;
constexpr int kMaxSteps = 5;

// Returns the inverse depth, along the last observation's ray, of the point that the other views
// see nearest to their own rays. Let d be that ray and t the last view's center, both in the frame
// of another camera that sees the direction u. The point is along d + c t there, and u x (d + c t)
// = 0 is linear in c. (The point nearest to all rays in space is not used: for almost parallel rays
// it is close to the cameras, and the iterations do not recover from there.)
std::optional<double> InitialInverseDepth(std::span<const PosedObservation> observations) {
  const PosedObservation& last = observations.back();
  const Eigen::Vector3d ray =
      last.view->cam_from_local_rotation.transpose() * (last.ray_in_cam / last.ray_in_cam.z());
  double product = 0.0;
  double sq_norm = 0.0;
  for (const PosedObservation& observation : observations.first(observations.size() - 1)) {
    const Eigen::Vector3d d = observation.view->cam_from_local_rotation * ray;
    const Eigen::Vector3d t = observation.view->ToCam(last.view->center_in_local);
    const Eigen::Vector3d across = observation.ray_in_cam.cross(t);
    product -= across.dot(observation.ray_in_cam.cross(d));
    sq_norm += across.squaredNorm();
  }
  return sq_norm > 0.0 ? std::optional(product / sq_norm) : std::nullopt;
}

// A point, as normalized image coordinates (a, b) and inverse depth c in one view.
class InverseDepth {
 public:
  InverseDepth(const CameraView& view, const Eigen::Vector3d& params)
      : view_(&view), params_(params) {}
  Eigen::Vector3d Point() const {
    return view_->center_in_local + view_->cam_from_local_rotation.transpose() *
                                        Eigen::Vector3d(params_[0], params_[1], 1.0) / params_[2];
  }
  // d point / d params.
  Eigen::Matrix3d Jacobian() const {
    Eigen::Matrix3d by_params = Eigen::Matrix3d::Identity() / params_[2];
    by_params.col(2) = -Eigen::Vector3d(params_[0], params_[1], 1.0) / (params_[2] * params_[2]);
    return view_->cam_from_local_rotation.transpose() * by_params;
  }
  double inverse_depth() const { return params_[2]; }
  InverseDepth Moved(const Eigen::Vector3d& step) const { return {*view_, params_ + step}; }

 private:
  const CameraView* view_;
  Eigen::Vector3d params_;
};

// Residuals are in pixels. The prior is weighted to match: its sigma_m counts as much as
// `sigma_px`.
std::optional<NormalSystem<3>> Linearize(const Camera& camera,
                                         std::span<const PosedObservation> observations,
                                         double sigma_px, const std::optional<PlanePrior>& prior,
                                         const InverseDepth& point) {
  if (!(point.inverse_depth() > 0.0)) {
    return std::nullopt;
  }
  NormalSystem<3> equations;
  const Eigen::Vector3d x_in_local = point.Point();
  const Eigen::Matrix3d by_params = point.Jacobian();
  for (const PosedObservation& observation : observations) {
    const auto predicted = PredictPixel(camera, *observation.view, x_in_local);
    if (!predicted) {
      return std::nullopt;
    }
    const Eigen::Vector2d residual = predicted->pixel - observation.pixel;
    const Eigen::Matrix<double, 2, 3> jacobian = predicted->by_local * by_params;
    equations.normal.noalias() += jacobian.transpose() * jacobian;
    equations.gradient.noalias() += jacobian.transpose() * residual;
    equations.cost += residual.squaredNorm();
  }
  if (prior) {
    const Eigen::Vector3d normal = sigma_px / prior->sigma_m * prior->normal_in_local;
    const double residual = normal.dot(x_in_local - prior->x_in_local);
    const Eigen::RowVector3d jacobian = normal.transpose() * by_params;
    equations.normal.noalias() += jacobian.transpose() * jacobian;
    equations.gradient.noalias() += residual * jacobian.transpose();
    equations.cost += residual * residual;
  }
  return equations;
}

bool WithinLimits(std::span<const PosedObservation> observations, const InverseDepth& point,
                  const NormalSystem<3>& equations, double sigma_px,
                  const TriangulateOptions& options) {
  const Eigen::Vector3d x_in_local = point.Point();
  for (const PosedObservation& observation : observations) {
    const double depth_m = observation.view->ToCam(x_in_local).z();
    if (!(depth_m > options.min_depth_m && depth_m < options.max_depth_m)) {
      return false;
    }
  }
  const double inverse_depth = point.inverse_depth();
  const double sq_sigma =
      sigma_px * sigma_px * equations.normal.ldlt().solve(Eigen::Vector3d::UnitZ())[2];
  return sq_sigma < std::pow(kMaxRelativeDepthSigma * inverse_depth, 2);
}

}  // namespace

void TriangulateOptions::Validate() const {
  RequireOption(min_depth_m > 0.0, "triangulate.min_depth_m must be positive");
  RequireOption(max_depth_m > min_depth_m, "triangulate.max_depth_m must be more than min_depth_m");
}

std::optional<Eigen::Vector3d> Triangulate(const Camera& camera,
                                           std::span<const PosedObservation> observations,
                                           double sigma_px, const TriangulateOptions& options,
                                           const std::optional<PlanePrior>& prior) {
  if (observations.size() < 2) {
    return std::nullopt;
  }
  const auto inverse_depth =
      prior ? std::optional(1.0 / observations.back().view->ToCam(prior->x_in_local).z())
            : InitialInverseDepth(observations);
  if (!inverse_depth) {
    return std::nullopt;
  }
  const PosedObservation& last = observations.back();
  Eigen::Vector3d params;
  params << last.ray_in_cam.hnormalized(),
      std::clamp(*inverse_depth, 1.0 / options.max_depth_m, 1.0 / options.min_depth_m);
  const auto minimum = MinimizeLeastSquares<3>(
      InverseDepth(*last.view, params),
      [&](const InverseDepth& point) {
        return Linearize(camera, observations, sigma_px, prior, point);
      },
      [](const InverseDepth& point, const Eigen::Vector3d& step) { return point.Moved(step); },
      {.max_steps = kMaxSteps,
       .initial_damping = 1e-6,
       .min_damping_after_failure = 1e-4,
       .min_predicted_decrease = 1e-4});
  if (!minimum || !minimum->has_converged ||
      !WithinLimits(observations, minimum->state, minimum->system, sigma_px, options)) {
    return std::nullopt;
  }
  return minimum->state.Point();
}

}  // namespace cairn::fusion
