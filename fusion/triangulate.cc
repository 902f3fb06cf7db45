#include "fusion/triangulate.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace cairn::fusion {
namespace {

// The point nearest to all rays, in the least-squares sense.
std::optional<Eigen::Vector3d> NearestToRays(std::span<const Sight> sights) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Sight& sight : sights) {
    const Eigen::Vector3d ray = sight.view->cam_from_local_rotation.transpose() * sight.ray_in_cam;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    normal += across;
    right += across * sight.view->center_in_local;
  }
  if (!(normal.determinant() > 1e-9)) {
    return std::nullopt;
  }
  return normal.ldlt().solve(right);
}

// A point by its normalised image coordinates (a, b) and inverse depth c in one view.
class InverseDepth {
 public:
  InverseDepth(const CameraView& view, const Eigen::Vector3d& x_in_local) : view_(view) {
    const Eigen::Vector3d x = view.ToCam(x_in_local);
    params_ << x.x() / x.z(), x.y() / x.z(), 1.0 / x.z();
  }
  Eigen::Vector3d Point() const { return PointAt(params_); }
  Eigen::Vector3d PointAt(const Eigen::Vector3d& params) const {
    return view_.center_in_local + view_.cam_from_local_rotation.transpose() *
                                       Eigen::Vector3d(params[0], params[1], 1.0) / params[2];
  }
  // d point / d params.
  Eigen::Matrix3d Jacobian() const {
    Eigen::Matrix3d by_params = Eigen::Matrix3d::Identity() / params_[2];
    by_params.col(2) = -Eigen::Vector3d(params_[0], params_[1], 1.0) / (params_[2] * params_[2]);
    return view_.cam_from_local_rotation.transpose() * by_params;
  }
  const Eigen::Vector3d& params() const { return params_; }
  void set_params(const Eigen::Vector3d& params) { params_ = params; }

 private:
  const CameraView& view_;
  Eigen::Vector3d params_;
};

struct NormalEquations {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double cost = 0.0;
};

std::optional<NormalEquations> Linearize(const Camera& camera, std::span<const Sight> sights,
                                         const InverseDepth& point) {
  NormalEquations equations;
  const Eigen::Vector3d x_in_local = point.Point();
  const Eigen::Matrix3d by_params = point.Jacobian();
  for (const Sight& sight : sights) {
    const auto predicted = PredictPixel(camera, *sight.view, x_in_local);
    if (!predicted) {
      return std::nullopt;
    }
    const Eigen::Vector2d residual = sight.pixel - predicted->pixel;
    const Eigen::Matrix<double, 2, 3> jacobian = predicted->by_local * by_params;
    equations.normal.noalias() += jacobian.transpose() * jacobian;
    equations.gradient.noalias() += jacobian.transpose() * residual;
    equations.cost += residual.squaredNorm();
  }
  return equations;
}

bool WithinLimits(std::span<const Sight> sights, const InverseDepth& point,
                  const NormalEquations& equations, double sigma_px,
                  const TriangulateOptions& options) {
  const Eigen::Vector3d x_in_local = point.Point();
  for (const Sight& sight : sights) {
    const double depth_m = sight.view->ToCam(x_in_local).z();
    if (!(depth_m > options.min_depth_m && depth_m < options.max_depth_m)) {
      return false;
    }
  }
  const double inverse_depth = point.params()[2];
  const double sq_sigma =
      sigma_px * sigma_px * equations.normal.ldlt().solve(Eigen::Vector3d::UnitZ())[2];
  return sq_sigma < std::pow(options.max_relative_depth_sigma * inverse_depth, 2);
}

}  // namespace

void TriangulateOptions::Validate() const {
  if (!(min_depth_m > 0.0 && max_depth_m > min_depth_m && max_relative_depth_sigma > 0.0 &&
        max_iterations >= 0)) {
    throw Error(ErrorCode::kInvalidArgument,
                "triangulation: depths must be positive and in order, limits positive");
  }
}

std::optional<Eigen::Vector3d> Triangulate(const Camera& camera, std::span<const Sight> sights,
                                           double sigma_px, const TriangulateOptions& options) {
  if (sights.size() < 2) {
    return std::nullopt;
  }
  const auto nearest = NearestToRays(sights);
  if (!nearest || !(sights.back().view->ToCam(*nearest).z() > options.min_depth_m)) {
    return std::nullopt;
  }
  InverseDepth point(*sights.back().view, *nearest);
  auto equations = Linearize(camera, sights, point);
  double damping = 1e-6;
  for (int i = 0; equations && i < options.max_iterations; ++i) {
    Eigen::Matrix3d damped = equations->normal;
    damped.diagonal() *= 1.0 + damping;
    const Eigen::Vector3d old_params = point.params();
    const Eigen::Vector3d step = damped.ldlt().solve(equations->gradient);
    point.set_params(old_params + step);
    const auto moved = point.params()[2] > 0.0 ? Linearize(camera, sights, point) : std::nullopt;
    if (moved && moved->cost <= equations->cost) {
      const double decrease = equations->cost - moved->cost;
      equations = moved;
      damping *= 0.1;
      if (decrease < 1e-4 * moved->cost + 1e-12) {
        break;
      }
    } else {
      point.set_params(old_params);
      damping = std::max(1e-4, damping) * 10.0;
    }
  }
  if (!equations || !WithinLimits(sights, point, *equations, sigma_px, options)) {
    return std::nullopt;
  }
  return point.Point();
}

}  // namespace cairn::fusion
