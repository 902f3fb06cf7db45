#include "core/lens.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/angles.h"

namespace cairn {
namespace {

constexpr double kHalfPi = 0.5 * kPi;
// The tangent of 84 degrees off the axis, which is beyond the edge of any perspective image.
constexpr double kMaxRadius = 10.0;
// Below these bounds, series replace quotients of small numbers.
constexpr double kSmallSqRadius = 1e-16;
constexpr double kSmallOmegaRad = 1e-6;
constexpr double kMaxThetaRad = kHalfPi - 1e-3;

// Returns the derivative of `point` times `factor`, which depends on the point's radius;
// `by_square` is d(factor)/d(squared radius).
Eigen::Matrix2d ScaleJacobian(const Eigen::Vector2d& point, double factor, double by_square) {
  return factor * Eigen::Matrix2d::Identity() + 2.0 * by_square * point * point.transpose();
}

// Newton's method for forward(point, &jacobian) == target. Returns nothing where the function turns
// over.
template <typename Forward>
std::optional<Eigen::Vector2d> Invert(const Forward& forward, const Eigen::Vector2d& target,
                                      Eigen::Vector2d point) {
  for (int i = 0; i < 50; ++i) {
    Eigen::Matrix2d jacobian;
    const Eigen::Vector2d excess = forward(point, &jacobian) - target;
    if (!(jacobian.determinant() > 0.0)) {
      return std::nullopt;
    }
    const Eigen::Vector2d step = jacobian.inverse() * excess;
    point -= step;
    if (step.squaredNorm() < 1e-24) {
      break;
    }
  }
  return point;
}

}  // namespace

Lens::Lens(const LensCoefficients& coefficients) : k_(coefficients) {
  if (k_.projection == LensProjection::kFov && std::abs(k_.omega_rad) < kSmallOmegaRad) {
    k_.projection = LensProjection::kPerspective;
  }
  const auto is_set = [](double value) { return value != 0.0; };
  has_radial_ = std::any_of(k_.numerator.begin(), k_.numerator.end(), is_set) ||
                std::any_of(k_.denominator.begin(), k_.denominator.end(), is_set);
  has_asymmetric_ = is_set(k_.p1) || is_set(k_.p2) || is_set(k_.s1) || is_set(k_.s2) ||
                    is_set(k_.s3) || is_set(k_.s4);
  max_sq_radius_ = FindMaxSqRadius();
}

Lens::Scale Lens::ProjectionScale(double sq_radius) const {
  if (k_.projection == LensProjection::kPerspective) {
    return {};
  }
  const bool is_fov = k_.projection == LensProjection::kFov;
  // Both projections are atan(slope * radius) / (turn * radius).
  const double slope = is_fov ? 2.0 * std::tan(0.5 * k_.omega_rad) : 1.0;
  const double turn = is_fov ? k_.omega_rad : 1.0;
  if (sq_radius < kSmallSqRadius) {
    return {slope / turn, -slope * slope * slope / (3.0 * turn)};
  }
  const double radius = std::sqrt(sq_radius);
  const double factor = std::atan(slope * radius) / (turn * radius);
  const double derivative = slope / (turn * (1.0 + slope * slope * sq_radius));
  return {factor, (derivative - factor) / (2.0 * sq_radius)};
}

Lens::Scale Lens::RadialScale(double q) const {
  if (!has_radial_) {
    return {};
  }
  const auto& n = k_.numerator;
  const auto& d = k_.denominator;
  double numerator = 0.0, numerator_by_q = 0.0;
  for (size_t i = n.size(); i-- > 0;) {
    numerator_by_q = numerator_by_q * q + numerator;
    numerator = numerator * q + n[i];
  }
  numerator_by_q = numerator_by_q * q + numerator;
  numerator = numerator * q + 1.0;
  const double denominator = 1.0 + q * (d[0] + q * (d[1] + q * d[2]));
  const double denominator_by_q = d[0] + q * (2.0 * d[1] + q * 3.0 * d[2]);
  const double factor = numerator / denominator;
  return {factor, (numerator_by_q - factor * denominator_by_q) / denominator};
}

// The distorted radius grows while factor + 2 q factor' is positive and the denominator has not
// reached zero.
double Lens::FindMaxSqRadius() const {
  double max_q = kMaxRadius * kMaxRadius;
  if (k_.projection == LensProjection::kEquidistant) {
    max_q = kHalfPi * kHalfPi;
  } else if (k_.projection == LensProjection::kFov) {
    max_q *= std::pow(ProjectionScale(max_q).factor, 2);
  }
  if (!has_radial_) {
    return max_q;
  }
  const auto& d = k_.denominator;
  const auto grows = [&](double q) {
    const Scale scale = RadialScale(q);
    return 1.0 + q * (d[0] + q * (d[1] + q * d[2])) > 0.0 &&
           scale.factor + 2.0 * q * scale.by_square > 0.0;
  };
  constexpr int kNumSteps = 2000;
  double low = 0.0;
  for (int i = 1; i <= kNumSteps; ++i) {
    double high = max_q * i / kNumSteps;
    if (grows(high)) {
      low = high;
      continue;
    }
    for (int j = 0; j < 60; ++j) {
      const double middle = 0.5 * (low + high);
      (grows(middle) ? low : high) = middle;
    }
    return low;
  }
  return max_q;
}

Eigen::Vector2d Lens::SkewAt(const Eigen::Vector2d& point, Eigen::Matrix2d* jacobian) const {
  const double a = point.x(), b = point.y();
  const double r = point.squaredNorm();
  if (jacobian != nullptr) {
    const double cross = 2.0 * k_.p1 * a + 2.0 * k_.p2 * b;
    const double prism_x = 2.0 * (k_.s1 + 2.0 * k_.s3 * r);
    const double prism_y = 2.0 * (k_.s2 + 2.0 * k_.s4 * r);
    *jacobian << 2.0 * k_.p1 * b + 6.0 * k_.p2 * a + prism_x * a, cross + prism_x * b,
        cross + prism_y * a, 6.0 * k_.p1 * b + 2.0 * k_.p2 * a + prism_y * b;
  }
  return {2.0 * k_.p1 * a * b + k_.p2 * (r + 2.0 * a * a) + r * (k_.s1 + k_.s3 * r),
          2.0 * k_.p2 * a * b + k_.p1 * (r + 2.0 * b * b) + r * (k_.s2 + k_.s4 * r)};
}

Eigen::Vector2d Lens::Bend(const Eigen::Vector2d& projected, Eigen::Matrix2d* jacobian) const {
  const Scale radial = RadialScale(projected.squaredNorm());
  const Eigen::Vector2d scaled = radial.factor * projected;
  if (jacobian != nullptr) {
    *jacobian = ScaleJacobian(projected, radial.factor, radial.by_square);
  }
  if (!has_asymmetric_) {
    return scaled;
  }
  const bool of_scaled = k_.skews_scaled_point;
  Eigen::Matrix2d skew_jacobian;
  const Eigen::Vector2d skew =
      SkewAt(of_scaled ? scaled : projected, jacobian == nullptr ? nullptr : &skew_jacobian);
  if (jacobian != nullptr) {
    *jacobian += of_scaled ? Eigen::Matrix2d(skew_jacobian * *jacobian) : skew_jacobian;
  }
  return scaled + skew;
}

std::optional<Eigen::Vector2d> Lens::Distort(const Eigen::Vector2d& normalized,
                                             Eigen::Matrix2d* jacobian) const {
  const Scale projection = ProjectionScale(normalized.squaredNorm());
  const Eigen::Vector2d projected = projection.factor * normalized;
  if (!(projected.squaredNorm() <= max_sq_radius_)) {
    return std::nullopt;
  }
  const Eigen::Vector2d distorted = Bend(projected, jacobian);
  if (jacobian != nullptr && k_.projection != LensProjection::kPerspective) {
    *jacobian *= ScaleJacobian(normalized, projection.factor, projection.by_square);
  }
  return distorted;
}

// Newton's method between bounds; the distorted radius grows with the radius up to max_sq_radius_.
double Lens::StraightenRadius(double distorted_radius) const {
  double low = 0.0, high = std::sqrt(max_sq_radius_);
  // Starts below `high`, where a rational factor may have its pole.
  double radius = distorted_radius < high ? distorted_radius : 0.5 * high;
  for (int i = 0; i < 100; ++i) {
    const Scale scale = RadialScale(radius * radius);
    const double excess = radius * scale.factor - distorted_radius;
    (excess > 0.0 ? high : low) = radius;
    const double slope = scale.factor + 2.0 * radius * radius * scale.by_square;
    double next = radius - excess / slope;
    if (!(next >= low && next <= high)) {
      next = 0.5 * (low + high);
    }
    const double step = std::abs(next - radius);
    radius = next;
    if (step <= 1e-15 * (1.0 + radius)) {
      break;
    }
  }
  return radius;
}

Eigen::Vector2d Lens::StraightenRadially(const Eigen::Vector2d& scaled) const {
  const double radius = scaled.norm();
  return has_radial_ && radius > 1e-8 ? scaled * (StraightenRadius(radius) / radius) : scaled;
}

std::optional<Eigen::Vector2d> Lens::Straighten(const Eigen::Vector2d& distorted) const {
  if (!has_asymmetric_) {
    return StraightenRadially(distorted);
  }
  if (k_.skews_scaled_point) {
    const std::optional<Eigen::Vector2d> scaled = Invert(
        [&](const Eigen::Vector2d& point, Eigen::Matrix2d* jacobian) {
          const Eigen::Vector2d skew = SkewAt(point, jacobian);
          *jacobian += Eigen::Matrix2d::Identity();
          return Eigen::Vector2d(point + skew);
        },
        distorted, distorted);
    return scaled ? std::optional(StraightenRadially(*scaled)) : std::nullopt;
  }
  return Invert([&](const Eigen::Vector2d& point,
                    Eigen::Matrix2d* jacobian) { return Bend(point, jacobian); },
                distorted, StraightenRadially(distorted));
}

std::optional<Eigen::Vector2d> Lens::Unproject(const Eigen::Vector2d& projected) const {
  if (k_.projection == LensProjection::kPerspective) {
    return projected;
  }
  const bool is_fov = k_.projection == LensProjection::kFov;
  const double slope = is_fov ? 2.0 * std::tan(0.5 * k_.omega_rad) : 1.0;
  const double turn = is_fov ? k_.omega_rad : 1.0;
  const double radius = projected.norm();
  if (radius < 1e-8) {
    return projected * (turn / slope);
  }
  if (!(radius * std::abs(turn) < kMaxThetaRad)) {
    return std::nullopt;
  }
  return projected * (std::tan(radius * turn) / (radius * slope));
}

std::optional<Eigen::Vector2d> Lens::Undistort(const Eigen::Vector2d& distorted) const {
  const std::optional<Eigen::Vector2d> projected = Straighten(distorted);
  if (!projected) {
    return std::nullopt;
  }
  const std::optional<Eigen::Vector2d> normalized = Unproject(*projected);
  if (!normalized) {
    return std::nullopt;
  }
  const std::optional<Eigen::Vector2d> again = Distort(*normalized, nullptr);
  constexpr double kTolerance = 1e-11;
  if (!again || !((*again - distorted).norm() < kTolerance * (1.0 + distorted.norm()))) {
    return std::nullopt;
  }
  return normalized;
}

}  // namespace cairn
