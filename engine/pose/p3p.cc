#include "engine/pose/p3p.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace cairn {
namespace {

using Triple = std::array<Eigen::Vector3d, 3>;

// The cosines b between bearings and the squared distances a between landmarks, for the pairs (1,
// 2), (1, 3), (2, 3). The depths l satisfy l_i^2 + l_j^2 - 2 b_ij l_i l_j = a_ij.
struct DistanceEquations {
  std::array<double, 3> cosine;
  std::array<double, 3> sq_distance;
};
constexpr std::array<std::array<int, 2>, 3> kPairs = {{{0, 1}, {0, 2}, {1, 2}}};

DistanceEquations MakeEquations(const Triple& bearings, const Triple& points) {
  DistanceEquations equations;
  for (int k = 0; k < 3; ++k) {
    const auto [i, j] = kPairs[k];
    equations.cosine[k] = bearings[i].dot(bearings[j]);
    equations.sq_distance[k] = (points[i] - points[j]).squaredNorm();
  }
  return equations;
}

// Returns the quadratic form of the left side of equation `k`.
Eigen::Matrix3d DistanceForm(const DistanceEquations& equations, int k) {
  const auto [i, j] = kPairs[k];
  Eigen::Matrix3d form = Eigen::Matrix3d::Zero();
  form(i, i) = form(j, j) = 1.0;
  form(i, j) = form(j, i) = -equations.cosine[k];
  return form;
}

// Returns a real root of c3 x^3 + c2 x^2 + c1 x + c0, where |c3| >= |c0|. Among several roots,
// returns the best conditioned one. With x = tan t, that is the root at which the cubic, as a form
// on the circle of (cos t, sin t), is steepest. Returns nothing if all coefficients are zero.
std::optional<double> RealCubicRoot(double c3, double c2, double c1, double c0) {
  const double scale = std::max({std::abs(c3), std::abs(c2), std::abs(c1)});
  if (!(scale > 0.0)) {
    return std::nullopt;
  }
  if (std::abs(c3) <= 1e-14 * scale) {
    return 0.0;  // c0 is zero, too.
  }
  const double b = c2 / c3, c = c1 / c3, d = c0 / c3;
  // x = y - b / 3 removes the quadratic term: y^3 + p y + q = 0.
  const double p = c - b * b / 3.0;
  const double q = b * (2.0 * b * b / 27.0 - c / 3.0) + d;
  const double discriminant = q * q / 4.0 + p * p * p / 27.0;
  std::array<double, 3> roots;
  int num_roots = 1;
  if (discriminant > 0.0) {
    const double root = std::sqrt(discriminant);
    const double u = std::cbrt(q > 0.0 ? -q / 2.0 - root : -q / 2.0 + root);
    roots[0] = (u != 0.0 ? u - p / (3.0 * u) : 0.0) - b / 3.0;
  } else {
    const double radius = 2.0 * std::sqrt(std::max(0.0, -p / 3.0));
    const double cosine = radius > 0.0 ? std::clamp(3.0 * q / (p * radius), -1.0, 1.0) : 1.0;
    // The cosines of a third of the angle, and of that angle less one and two thirds of a turn.
    const double third = std::cos(std::acos(cosine) / 3.0);
    const double sine = 0.5 * std::numbers::sqrt3 * std::sqrt(1.0 - third * third);
    num_roots = 3;
    roots = {radius * third - b / 3.0, radius * (sine - 0.5 * third) - b / 3.0,
             radius * (-sine - 0.5 * third) - b / 3.0};
  }
  const auto slope = [&](double x) { return (3.0 * x + 2.0 * b) * x + c; };
  const auto sq_steepness = [&](double x) { return slope(x) * slope(x) / (1.0 + x * x); };
  double best = roots[0];
  for (int i = 1; i < num_roots; ++i) {
    best = sq_steepness(roots[i]) > sq_steepness(best) ? roots[i] : best;
  }
  // Newton steps remove the rounding errors of the closed form.
  for (int i = 0; i < 2 && slope(best) != 0.0; ++i) {
    best -= (((best + b) * best + c) * best + d) / slope(best);
  }
  return best;
}

// Returns the determinant of the matrix with these columns.
double Det(const Eigen::Vector3d& x, const Eigen::Vector3d& y, const Eigen::Vector3d& z) {
  return x.dot(y.cross(z));
}

// Returns the sum of the principal 2x2 minors of a symmetric matrix.
double PrincipalMinors(const Eigen::Matrix3d& m) {
  return m(0, 0) * m(1, 1) - m(0, 1) * m(0, 1) + m(0, 0) * m(2, 2) - m(0, 2) * m(0, 2) +
         m(1, 1) * m(2, 2) - m(1, 2) * m(1, 2);
}

// Returns the eigenvector of a symmetric matrix for a simple eigenvalue, with length sqrt(|value|).
Eigen::Vector3d ScaledEigenvector(const Eigen::Matrix3d& m, double value) {
  const Eigen::Matrix3d shifted = m - value * Eigen::Matrix3d::Identity();
  // The eigenvector is orthogonal to all rows. The longest cross product of two rows is the best
  // conditioned.
  const Eigen::Vector3d row0 = shifted.col(0), row1 = shifted.col(1), row2 = shifted.col(2);
  Eigen::Vector3d best = row0.cross(row1);
  for (const Eigen::Vector3d& other : {row0.cross(row2), row1.cross(row2)}) {
    if (other.squaredNorm() > best.squaredNorm()) {
      best = other;
    }
  }
  return std::sqrt(std::abs(value) / best.squaredNorm()) * best;
}

// Two lines n . l = 0 and a conic, which meet in the points that all conics of the pencil share.
struct LinesAndConic {
  std::array<Eigen::Vector3d, 2> lines;
  Eigen::Matrix3d conic;
};

// Splits a degenerate member A + x B of the pencil into its lines. The conic is A or B, whichever
// is farther from that member. Requires |det B| >= |det A|.
std::optional<LinesAndConic> SplitDegenerateConic(const Eigen::Matrix3d& a,
                                                  const Eigen::Matrix3d& b) {
  const auto col = [](const Eigen::Matrix3d& m, int i) -> Eigen::Vector3d { return m.col(i); };
  const double c2 = Det(col(a, 0), col(b, 1), col(b, 2)) + Det(col(b, 0), col(a, 1), col(b, 2)) +
                    Det(col(b, 0), col(b, 1), col(a, 2));
  const double c1 = Det(col(b, 0), col(a, 1), col(a, 2)) + Det(col(a, 0), col(b, 1), col(a, 2)) +
                    Det(col(a, 0), col(a, 1), col(b, 2));
  const std::optional<double> x = RealCubicRoot(b.determinant(), c2, c1, a.determinant());
  if (!x) {
    return std::nullopt;
  }
  const Eigen::Matrix3d degenerate = a + *x * b;
  // One eigenvalue is zero, so the others are the roots of a quadratic. Their sum is the trace and
  // their product the sum of the principal minors.
  const double half_trace = 0.5 * degenerate.trace();
  const double product = PrincipalMinors(degenerate);
  if (!(product < 0.0)) {
    return std::nullopt;
  }
  const double larger =
      half_trace + std::copysign(std::sqrt(half_trace * half_trace - product), half_trace);
  const double smaller = product / larger;
  const Eigen::Vector3d plus = ScaledEigenvector(degenerate, std::max(larger, smaller));
  const Eigen::Vector3d minus = ScaledEigenvector(degenerate, std::min(larger, smaller));
  return LinesAndConic{{plus + minus, plus - minus}, std::abs(*x) > 1.0 ? a : b};
}

// Finds the points, up to scale, in which the line n . l = 0 meets the conic l' D l = 0. Returns
// their number, 0 or 2.
int MeetLineWithConic(const Eigen::Vector3d& n, const Eigen::Matrix3d& conic,
                      std::array<Eigen::Vector3d, 2>* points) {
  const Eigen::Vector3d e = n.unitOrthogonal();
  const Eigen::Vector3d f = n.cross(e).normalized();
  const double a = e.dot(conic * e), half_b = e.dot(conic * f), c = f.dot(conic * f);
  const double discriminant = half_b * half_b - a * c;
  // A double root (the danger cylinder) may round to a negative discriminant.
  if (!(discriminant > -1e-12 * (half_b * half_b + std::abs(a * c)))) {
    return 0;
  }
  const double root = std::sqrt(std::max(0.0, discriminant));
  const double q = -(half_b + std::copysign(root, half_b));
  (*points)[0] = q * e + a * f;
  (*points)[1] = c * e + q * f;
  return 2;
}

// Scales the depths to the distances and refines them by Gauss-Newton. Returns false unless all
// depths are positive and the distances are met.
bool PolishDepths(const DistanceEquations& equations, Eigen::Vector3d* depths) {
  const auto residual = [&](const Eigen::Vector3d& l, int k, double sq_distance) {
    const auto [i, j] = kPairs[k];
    return l[i] * l[i] + l[j] * l[j] - 2.0 * equations.cosine[k] * l[i] * l[j] - sq_distance;
  };
  double form = 0.0, sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    form += residual(*depths, k, 0.0);
    sum += equations.sq_distance[k];
  }
  if (!(form > 0.0)) {
    return false;
  }
  *depths *= std::copysign(std::sqrt(sum / form), depths->sum());
  if (!(depths->minCoeff() > 0.0)) {
    return false;
  }
  double worst = 0.0;
  for (int iteration = 0; iteration < 3; ++iteration) {
    Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
    Eigen::Vector3d r;
    for (int k = 0; k < 3; ++k) {
      const auto [i, j] = kPairs[k];
      r[k] = residual(*depths, k, equations.sq_distance[k]);
      jacobian(k, i) = 2.0 * ((*depths)[i] - equations.cosine[k] * (*depths)[j]);
      jacobian(k, j) = 2.0 * ((*depths)[j] - equations.cosine[k] * (*depths)[i]);
    }
    worst = r.cwiseAbs().maxCoeff();
    Eigen::Matrix3d inverse;
    bool invertible = false;
    jacobian.computeInverseWithCheck(inverse, invertible, 1e-12);
    if (worst < 1e-14 * sum || !invertible) {
      break;
    }
    *depths -= inverse * r;
    if (worst < 1e-9 * sum) {  // The next residual would be about the square of this one.
      break;
    }
  }
  return depths->minCoeff() > 0.0 && worst < 1e-6 * sum;
}

// Computes orthonormal axes of the plane through three points. Returns false if the points are
// collinear.
bool TriangleAxes(const Triple& points, Eigen::Matrix3d* axes) {
  const Eigen::Vector3d side = points[1] - points[0];
  const Eigen::Vector3d normal = side.cross(points[2] - points[0]);
  if (!(normal.squaredNorm() >
        1e-20 * side.squaredNorm() * (points[2] - points[0]).squaredNorm())) {
    return false;
  }
  axes->col(0) = side.normalized();
  axes->col(2) = normal.normalized();
  axes->col(1) = axes->col(2).cross(axes->col(0));
  return true;
}

}  // namespace

int SolveP3p(const std::array<Eigen::Vector3d, 3>& bearings_in_cam,
             const std::array<Eigen::Vector3d, 3>& x_in_anchor,
             std::array<Eigen::Matrix<double, 3, 4>, 4>* solutions) {
  Eigen::Matrix3d axes_in_anchor;
  if (!TriangleAxes(x_in_anchor, &axes_in_anchor)) {
    return 0;
  }
  const DistanceEquations equations = MakeEquations(bearings_in_cam, x_in_anchor);
  if (*std::max_element(equations.cosine.begin(), equations.cosine.end()) >= 1.0 - 1e-15) {
    return 0;
  }
  // Two members of the pencil, dimensionless: equations 1 and 2, with the right side eliminated by
  // equation 3.
  const double a12 = equations.sq_distance[0] / equations.sq_distance[2];
  const double a13 = equations.sq_distance[1] / equations.sq_distance[2];
  const Eigen::Matrix3d form23 = DistanceForm(equations, 2);
  Eigen::Matrix3d first = DistanceForm(equations, 0) - a12 * form23;
  Eigen::Matrix3d second = DistanceForm(equations, 1) - a13 * form23;
  if (std::abs(first.determinant()) > std::abs(second.determinant())) {
    first.swap(second);  // Keeps the leading coefficient of the cubic away from zero.
  }
  const auto split = SplitDegenerateConic(first, second);
  if (!split) {
    return 0;
  }
  int num_solutions = 0;
  for (const Eigen::Vector3d& line : split->lines) {
    std::array<Eigen::Vector3d, 2> candidates;
    const int num_candidates = MeetLineWithConic(line, split->conic, &candidates);
    for (int i = 0; i < num_candidates; ++i) {
      Eigen::Vector3d& depths = candidates[i];
      if (!PolishDepths(equations, &depths)) {
        continue;
      }
      Eigen::Matrix3d axes_in_cam;
      const Triple points_in_cam = {depths[0] * bearings_in_cam[0], depths[1] * bearings_in_cam[1],
                                    depths[2] * bearings_in_cam[2]};
      if (!TriangleAxes(points_in_cam, &axes_in_cam)) {
        continue;
      }
      Eigen::Matrix<double, 3, 4>& cam_from_anchor = (*solutions)[num_solutions++];
      cam_from_anchor.leftCols<3>() = axes_in_cam * axes_in_anchor.transpose();
      cam_from_anchor.col(3) = points_in_cam[0] - cam_from_anchor.leftCols<3>() * x_in_anchor[0];
    }
  }
  return num_solutions;
}

}  // namespace cairn
