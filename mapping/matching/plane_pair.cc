#include "mapping/matching/plane_pair.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/random.h"

namespace cairn {
namespace {

// If half of the points lie on the plane, one sample of three in eight has only such points.
constexpr int kPlaneSamples = 50;
constexpr size_t kMaxScored = 200;
constexpr int kPlaneRounds = 5;
// Poses that differ by less are one for the growth of a segment.
constexpr double kLeastTwinTurnRad = 0.0175;

// How far a point at the plane's depth along ray a is from ray b, beside the epipolar error: linear
// in the normal, as slope . normal - offset, in standard deviations.
struct PlaneEquation {
  Eigen::Vector3d slope;
  double offset = 0.0;

  double ErrorOf(const Eigen::Vector3d& normal_in_a) const {
    return slope.dot(normal_in_a) - offset;
  }
};

PlaneEquation EquationOf(const RayMatch& match, const Rigid3d& b_from_a) {
  // b x (R a + t (a . n)) = 0, along b x t.
  const Eigen::Vector3d across = match.b.cross(b_from_a.translation);
  const double sine = across.norm();
  const double sigma = std::sqrt(match.SqSigmaRad());
  PlaneEquation equation{sine / sigma * match.a, 0.0};
  if (sine > 0.0) {
    equation.offset = -across.dot(match.b.cross(b_from_a.rotation * match.a)) / (sine * sigma);
  }
  return equation;
}

std::optional<Eigen::Vector3d> NormalOfThree(const std::vector<PlaneEquation>& equations,
                                             Random* random) {
  Eigen::Matrix3d slopes;
  Eigen::Vector3d offsets;
  for (int i = 0; i < 3; ++i) {
    const PlaneEquation& equation = equations[random->Index(static_cast<int>(equations.size()))];
    slopes.row(i) = equation.slope.transpose();
    offsets[i] = equation.offset;
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(slopes);
  return lu.isInvertible() ? std::optional<Eigen::Vector3d>(lu.solve(offsets)) : std::nullopt;
}

// Sum of what each equation that holds within four standard deviations gains.
double GainOf(const std::vector<PlaneEquation>& equations, const Eigen::Vector3d& normal_in_a) {
  const size_t stride = std::max<size_t>(1, equations.size() / kMaxScored);
  double gain = 0.0;
  for (size_t i = 0; i < equations.size(); i += stride) {
    const double error = equations[i].ErrorOf(normal_in_a) / kMaxEpipolarSigmas;
    gain += std::max(0.0, 1.0 - error * error);
  }
  return gain;
}

}  // namespace

std::optional<SeenPlane> FitPlane(std::span<const RayMatch> matches, std::span<const int> inliers,
                                  const Rigid3d& b_from_a, uint64_t seed) {
  if (inliers.size() < 3) {
    return std::nullopt;
  }
  std::vector<PlaneEquation> equations;
  for (const int i : inliers) {
    equations.push_back(EquationOf(matches[i], b_from_a));
  }
  Random random(seed);
  SeenPlane plane;
  double best = 0.0;
  for (int i = 0; i < kPlaneSamples; ++i) {
    if (const auto normal = NormalOfThree(equations, &random)) {
      const double gain = GainOf(equations, *normal);
      if (gain > best) {
        best = gain;
        plane.normal_in_a = *normal;
      }
    }
  }
  if (best == 0.0) {
    return std::nullopt;
  }
  for (int round = 0; round < kPlaneRounds; ++round) {
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const PlaneEquation& equation : equations) {
      const double error = equation.ErrorOf(plane.normal_in_a);
      const double sq_ratio = error * error / (kMaxEpipolarSigmas * kMaxEpipolarSigmas);
      const double weight = 1.0 / ((1.0 + sq_ratio) * (1.0 + sq_ratio));
      moments += weight * equation.slope * equation.slope.transpose();
      right += weight * equation.offset * equation.slope;
    }
    plane.normal_in_a = moments.ldlt().solve(right);
  }
  if (!plane.normal_in_a.allFinite()) {
    return std::nullopt;
  }
  plane.num_explained = static_cast<int>(
      std::count_if(equations.begin(), equations.end(), [&](const PlaneEquation& equation) {
        return std::abs(equation.ErrorOf(plane.normal_in_a)) <= kMaxEpipolarSigmas;
      }));
  return plane;
}

// After Ma, Soatto, Kosecka and Sastry (2004), section 5.3: with a middle singular value of one, H
// keeps the lengths of the vectors of two planes, whose images determine the two rotations.
std::optional<PlaneTwin> TwinOf(const Rigid3d& b_from_a, const SeenPlane& plane,
                                const Eigen::Vector3d& rays_in_a) {
  const Eigen::Matrix3d unscaled =
      b_from_a.rotation.toRotationMatrix() + b_from_a.translation * plane.normal_in_a.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(unscaled, Eigen::ComputeFullV);
  const Eigen::Vector3d values = svd.singularValues() / svd.singularValues()[1];
  if (!(unscaled.determinant() > 0.0) || !values.allFinite() || values[0] - values[2] < 1e-6) {
    return std::nullopt;  // Camera b would be behind the plane, or has not moved.
  }
  const Eigen::Matrix3d homography = unscaled / svd.singularValues()[1];
  Eigen::Matrix3d v = svd.matrixV();
  v.col(2) *= v.determinant() < 0.0 ? -1.0 : 1.0;
  const double sq_first = values[0] * values[0], sq_last = values[2] * values[2];
  std::optional<PlaneTwin> twin;
  double largest_turn = kLeastTwinTurnRad;
  for (const double sign : {1.0, -1.0}) {
    const Eigen::Vector3d kept = (std::sqrt(std::max(0.0, 1.0 - sq_last)) * v.col(0) +
                                  sign * std::sqrt(std::max(0.0, sq_first - 1.0)) * v.col(2)) /
                                 std::sqrt(sq_first - sq_last);
    Eigen::Matrix3d before, after;
    before << v.col(1), kept, v.col(1).cross(kept);
    const Eigen::Vector3d first = homography * v.col(1), second = homography * kept;
    after << first, second, first.cross(second);
    const Eigen::Matrix3d rotation = after * before.transpose();
    const double turn = RotationAngleRad(Eigen::Quaterniond(rotation), b_from_a.rotation);
    Eigen::Vector3d normal = before.col(2);
    Eigen::Vector3d translation = (homography - rotation) * normal;
    if (turn > largest_turn && translation.norm() > 0.0) {
      if (normal.dot(rays_in_a) < 0.0) {
        normal = -normal;
        translation = -translation;
      }
      largest_turn = turn;
      twin = PlaneTwin{Rigid3d(rotation, translation.normalized()), normal};
    }
  }
  return twin;
}

}  // namespace cairn
