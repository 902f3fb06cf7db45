// Lens distortion: the map from normalized image coordinates (x / z, y / z) to distorted
// coordinates.
#ifndef CAIRN_CORE_LENS_H_
#define CAIRN_CORE_LENS_H_

#include <Eigen/Core>
#include <array>
#include <optional>

namespace cairn {

// The measure of an undistorted point's radius.
enum class LensProjection {
  kPerspective,  // The tangent of the angle off the axis.
  kEquidistant,  // The angle itself: the fisheyes.
  kFov,          // atan(2 tan(omega / 2) tan(angle)) / omega (Devernay and Faugeras).
};

// With (u, v) the point after the projection and q = u^2 + v^2:
//
//   radial = (1 + n0 q + n1 q^2 + ... + n5 q^6) / (1 + d0 q + d1 q^2 + d2 q^3)
//   x = u radial + 2 p1 a b + p2 (r + 2 a^2) + s1 r + s3 r^2
//   y = v radial + 2 p2 a b + p1 (r + 2 b^2) + s2 r + s4 r^2
//
// where (a, b) is (u, v), or (u radial, v radial) with `skews_scaled_point`, and r = a^2 + b^2. In
// each of COLMAP's models (core/camera.h), some of these coefficients are zero.
struct LensCoefficients {
  LensProjection projection = LensProjection::kPerspective;
  std::array<double, 6> numerator = {};
  std::array<double, 3> denominator = {};
  double p1 = 0.0, p2 = 0.0;                      // Tangential.
  double s1 = 0.0, s2 = 0.0, s3 = 0.0, s4 = 0.0;  // Thin prism.
  bool skews_scaled_point = false;  // Tangential and prism terms take the radially scaled point.
  double omega_rad = 0.0;           // Only for kFov; its magnitude is below pi.
};

// Immutable; safe to use from any thread.
class Lens {
 public:
  explicit Lens(const LensCoefficients& coefficients);

  // Returns the distorted point. Returns nothing beyond the radius at which the distorted radius
  // stops growing, or beyond 84 degrees off the axis for a lens that is not a fisheye. `jacobian`
  // (may be null) receives d(distorted)/d(normalized).
  std::optional<Eigen::Vector2d> Distort(const Eigen::Vector2d& normalized,
                                         Eigen::Matrix2d* jacobian) const;

  // The inverse of Distort to 1e-11; nothing if the point has no inverse.
  std::optional<Eigen::Vector2d> Undistort(const Eigen::Vector2d& distorted) const;

 private:
  // A factor on a point, and the factor's derivative with respect to the squared radius.
  struct Scale {
    double factor = 1.0;
    double by_square = 0.0;
  };
  Scale ProjectionScale(double sq_radius) const;
  Scale RadialScale(double sq_radius) const;
  // Maps the projected point to the distorted point.
  Eigen::Vector2d Bend(const Eigen::Vector2d& projected, Eigen::Matrix2d* jacobian) const;
  // The tangential and prism terms at a point.
  Eigen::Vector2d SkewAt(const Eigen::Vector2d& point, Eigen::Matrix2d* jacobian) const;
  std::optional<Eigen::Vector2d> Straighten(const Eigen::Vector2d& distorted) const;
  Eigen::Vector2d StraightenRadially(const Eigen::Vector2d& scaled) const;
  double StraightenRadius(double distorted_radius) const;
  std::optional<Eigen::Vector2d> Unproject(const Eigen::Vector2d& projected) const;
  double FindMaxSqRadius() const;

  LensCoefficients k_;
  bool has_radial_ = false;      // True if a coefficient of `radial` is not zero.
  bool has_asymmetric_ = false;  // True if a tangential or prism coefficient is not zero.
  double max_sq_radius_ = 0.0;   // Limit on the projected point.
};

}  // namespace cairn

#endif  // CAIRN_CORE_LENS_H_
