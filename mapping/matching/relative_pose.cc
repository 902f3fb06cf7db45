#include "mapping/matching/relative_pose.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/angles.h"
#include "core/least_squares.h"

namespace cairn {
namespace {

constexpr double kSqMaxError = kMaxEpipolarSigmas * kMaxEpipolarSigmas;
// Scale of Cauchy's loss, in standard deviations, as in triangulation.
constexpr double kSqLossScale = 2.0 * 2.0;
constexpr int kMaxSteps = 10;
// The noise is told by this quantile of the errors, so that a few wrong matches do not count.
constexpr double kNoiseQuantile = 0.8;
constexpr double kNoiseQuantileSigmas = 1.2816;  // Of a normal error.

using Tangent = Eigen::Matrix<double, 5, 1>;  // Rotation (3), direction of the translation (2).

Eigen::Matrix<double, 3, 2> TangentPlane(const Eigen::Vector3d& direction) {
  Eigen::Matrix<double, 3, 2> plane;
  plane.col(0) = direction.unitOrthogonal();
  plane.col(1) = direction.cross(plane.col(0));
  return plane;
}

Rigid3d Moved(const Rigid3d& b_from_a, const Tangent& step) {
  const Eigen::Vector3d direction =
      b_from_a.translation + TangentPlane(b_from_a.translation) * step.tail<2>();
  return {ExpSo3(step.head<3>()) * b_from_a.rotation, direction.normalized()};
}

// Of b' E a.
double EpipolarVariance(const Eigen::Matrix3d& essential, const RayMatch& match) {
  return (match.spread_b.transpose() * (essential * match.a)).squaredNorm() +
         (match.spread_a.transpose() * (essential.transpose() * match.b)).squaredNorm();
}

// The derivative treats the variances as constants; they change slowly.
NormalSystem<5> LinearizeRelative(std::span<const RayMatch> matches, std::span<const int> inliers,
                                  const Rigid3d& b_from_a) {
  const Eigen::Matrix3d rotation = b_from_a.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = b_from_a.translation;
  const Eigen::Matrix3d essential = Skew(t) * rotation;
  const Eigen::Matrix<double, 3, 2> plane = TangentPlane(t);
  NormalSystem<5> equations;
  for (const int i : inliers) {
    const RayMatch& match = matches[i];
    const Eigen::Vector3d turned = rotation * match.a;
    const double sigma = std::sqrt(std::max(EpipolarVariance(essential, match), 1e-20));
    const double residual = match.b.dot(t.cross(turned)) / sigma;
    Tangent jacobian;
    // b . (t x (w x p)) = w . (p x (b x t)), and b . (dt x p) = dt . (p x b).
    jacobian.head<3>() = turned.cross(match.b.cross(t)) / sigma;
    jacobian.tail<2>() = plane.transpose() * turned.cross(match.b) / sigma;
    const double sq_residual = residual * residual;
    const double weight = 1.0 / (1.0 + sq_residual / kSqLossScale);
    equations.normal += weight * jacobian * jacobian.transpose();
    equations.gradient += weight * residual * jacobian;
    equations.cost += 0.5 * kSqLossScale * std::log1p(sq_residual / kSqLossScale);
  }
  return equations;
}

}  // namespace

RaySpread EvenSpread(const Eigen::Vector3d& ray, double sigma_rad) {
  return sigma_rad * TangentPlane(ray);
}

double SqEpipolarError(const Eigen::Matrix3d& essential, const RayMatch& match) {
  const double residual = match.b.dot(essential * match.a);
  return residual * residual /
         std::max(EpipolarVariance(essential, match), std::numeric_limits<double>::min());
}

double NoiseOf(std::span<const RayMatch> matches, std::span<const int> inliers,
               const Rigid3d& b_from_a) {
  if (inliers.empty()) {
    return 1.0;
  }
  const Eigen::Matrix3d essential = EssentialOf(b_from_a);
  std::vector<double> sq_errors;
  for (const int i : inliers) {
    sq_errors.push_back(SqEpipolarError(essential, matches[i]));
  }
  const auto at = sq_errors.begin() + static_cast<std::ptrdiff_t>(
                                          kNoiseQuantile * static_cast<double>(sq_errors.size()));
  std::nth_element(sq_errors.begin(), at, sq_errors.end());
  return std::clamp(std::sqrt(*at) / kNoiseQuantileSigmas, kLeastNoise, 1.0);
}

std::vector<RayMatch> WithNoise(std::span<const RayMatch> matches, double noise) {
  std::vector<RayMatch> scaled(matches.begin(), matches.end());
  for (RayMatch& match : scaled) {
    match.spread_a *= noise;
    match.spread_b *= noise;
  }
  return scaled;
}

Eigen::Matrix3d EssentialOf(const Rigid3d& b_from_a) {
  return Skew(b_from_a.translation) * b_from_a.rotation.toRotationMatrix();
}

std::optional<std::pair<double, double>> DepthsOf(const Rigid3d& b_from_a, const RayMatch& match) {
  // depth_b b = depth_a R a + t, in least squares.
  const Eigen::Vector3d turned = b_from_a.rotation * match.a;
  const double cosine = turned.dot(match.b);
  const double sq_sine = turned.cross(match.b).squaredNorm();
  if (sq_sine < 1e-14) {
    return std::nullopt;
  }
  const double along_a = turned.dot(b_from_a.translation);
  const double along_b = match.b.dot(b_from_a.translation);
  return std::pair((cosine * along_b - along_a) / sq_sine, (along_b - cosine * along_a) / sq_sine);
}

std::optional<RefinedRelativePose> RefineRelativePose(std::span<const RayMatch> matches,
                                                      std::span<const int> inliers,
                                                      const Rigid3d& b_from_a) {
  if (inliers.size() < 5) {
    return std::nullopt;
  }
  const auto minimum = MinimizeLeastSquares<5>(
      b_from_a,
      [&](const Rigid3d& pose) { return std::optional(LinearizeRelative(matches, inliers, pose)); },
      Moved, {.max_steps = kMaxSteps, .max_damping = 1e4, .min_decrease = 1e-6});
  RefinedRelativePose refined{.b_from_a = minimum->state};
  refined.cost = minimum->system.cost;
  Eigen::Matrix<double, 5, 5> floored = minimum->system.normal;
  floored.diagonal().array() +=
      1e-2;  // A direction that nothing determines is uncertain by 10 rad.
  const Eigen::Matrix<double, 5, 5> covariance = floored.inverse();
  const auto largest_sigma = [](const auto& block) {
    using Block = std::decay_t<decltype(block)>;
    return std::sqrt(Eigen::SelfAdjointEigenSolver<Block>(block, Eigen::EigenvaluesOnly)
                         .eigenvalues()
                         .maxCoeff());
  };
  refined.rotation_sigma_rad = largest_sigma(Eigen::Matrix3d(covariance.topLeftCorner<3, 3>()));
  refined.direction_sigma_rad =
      largest_sigma(Eigen::Matrix2d(covariance.bottomRightCorner<2, 2>()));
  return refined;
}

RotationFit FitRotation(std::span<const RayMatch> matches, std::span<const int> inliers,
                        const Eigen::Quaterniond& b_from_a) {
  constexpr int kRounds = 5;
  RotationFit fit{b_from_a};
  const auto sq_error = [&](const RayMatch& match) {
    return (fit.b_from_a * match.a).cross(match.b).squaredNorm() / match.SqSigmaRad();
  };
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    for (const int i : inliers) {
      moments +=
          matches[i].b * matches[i].a.transpose() / (1.0 + sq_error(matches[i]) / kSqLossScale);
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moments, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d signs = Eigen::Vector3d::Ones();
    signs[2] = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
    fit.b_from_a = Eigen::Matrix3d(svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose());
  }
  fit.num_explained = static_cast<int>(std::count_if(
      inliers.begin(), inliers.end(), [&](int i) { return sq_error(matches[i]) <= kSqMaxError; }));
  return fit;
}

RelativePoseProblem::RelativePoseProblem(std::span<const RayMatch> matches, uint64_t seed)
    : matches_(matches), order_(matches.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  Random random(seed);
  for (int i = static_cast<int>(order_.size()) - 1; i > 0; --i) {
    std::swap(order_[i], order_[random.Index(i + 1)]);
  }
}

int RelativePoseProblem::SampleModels(Random* random, std::array<Model, kMaxModels>* models) {
  std::array<int, 5> sample;
  for (int i = 0; i < 5; ++i) {
    do {
      // The square prefers the first matches: half of the draws are among the first quarter.
      const double fraction = random->Fraction();
      sample[i] = static_cast<int>(fraction * fraction * static_cast<double>(matches_.size()));
    } while (std::find(sample.begin(), sample.begin() + i, sample[i]) != sample.begin() + i);
  }
  std::array<Eigen::Vector3d, 5> a, b;
  for (int i = 0; i < 5; ++i) {
    a[i] = matches_[sample[i]].a;
    b[i] = matches_[sample[i]].b;
  }
  std::array<Eigen::Matrix3d, kMaxEssentials> essentials;
  const int count = SolveFivePoint(a, b, &essentials);
  for (int i = 0; i < count; ++i) {
    (*models)[i] = {essentials[i], Rigid3d()};
  }
  return count;
}

double RelativePoseProblem::ScoreMinimal(const Model& model, double score_to_beat) const {
  constexpr size_t kBatch = 16;
  double gain = 0.0;
  for (size_t begin = 0; begin < order_.size(); begin += kBatch) {
    if (gain + static_cast<double>(order_.size() - begin) <= score_to_beat) {
      return 0.0;
    }
    const size_t end = std::min(order_.size(), begin + kBatch);
    for (size_t i = begin; i < end; ++i) {
      const double sq_error = SqEpipolarError(model.essential, matches_[order_[i]]);
      gain += std::max(0.0, 1.0 - sq_error / kSqMaxError);
    }
  }
  return gain;
}

std::optional<std::pair<RelativePoseProblem::Model, double>> RelativePoseProblem::Optimize(
    const Model& model) const {
  constexpr int kRounds = 3;
  std::vector<int> inliers = EpipolarInliers(model.essential);
  if (inliers.size() < 6) {
    return std::nullopt;
  }
  Model best{model.essential, PoseOf(model.essential, inliers)};
  for (int round = 0; round < kRounds; ++round) {
    const auto refined = RefineRelativePose(matches_, inliers, best.b_from_a);
    if (!refined) {
      return std::nullopt;
    }
    best = {EssentialOf(refined->b_from_a), refined->b_from_a};
    std::vector<int> next = EpipolarInliers(best.essential);
    if (next == inliers) {
      break;
    }
    inliers = std::move(next);
  }
  return std::pair(best, ScoreMinimal(best, -1.0));
}

double RelativePoseProblem::InlierSampleProbability(const Model& model) const {
  return SampleProbabilityOfScore(static_cast<double>(EpipolarInliers(model.essential).size()));
}

double RelativePoseProblem::SampleProbabilityOfScore(double score) const {
  return std::pow(score / static_cast<double>(matches_.size()), 5);
}

std::vector<int> RelativePoseProblem::EpipolarInliers(const Eigen::Matrix3d& essential) const {
  std::vector<int> inliers;
  for (int i = 0; i < static_cast<int>(matches_.size()); ++i) {
    if (SqEpipolarError(essential, matches_[i]) <= kSqMaxError) {
      inliers.push_back(i);
    }
  }
  return inliers;
}

std::vector<int> RelativePoseProblem::InliersOf(const Rigid3d& b_from_a) const {
  std::vector<int> inliers = EpipolarInliers(EssentialOf(b_from_a));
  std::erase_if(inliers, [&](int i) {
    // Rays that are parallel within their errors meet behind the cameras as often as before them.
    const RayMatch& match = matches_[i];
    const double sq_sine = (b_from_a.rotation * match.a).cross(match.b).squaredNorm();
    const auto depths = DepthsOf(b_from_a, match);
    return sq_sine > kSqMaxError * match.SqSigmaRad() && depths &&
           (depths->first <= 0.0 || depths->second <= 0.0);
  });
  return inliers;
}

Rigid3d RelativePoseProblem::PoseOf(const Eigen::Matrix3d& essential,
                                    std::span<const int> inliers) const {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU(), v = svd.matrixV();
  u.col(2) *= u.determinant() < 0.0 ? -1.0 : 1.0;
  v.col(2) *= v.determinant() < 0.0 ? -1.0 : 1.0;
  const Eigen::Matrix3d quarter =
      Eigen::AngleAxisd(0.5 * kPi, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  Rigid3d best;
  int most_in_front = -1;
  for (const Eigen::Matrix3d& turn : {quarter, Eigen::Matrix3d(quarter.transpose())}) {
    for (const double sign : {1.0, -1.0}) {
      const Rigid3d pose(Eigen::Matrix3d(u * turn * v.transpose()), sign * u.col(2));
      const auto in_front = std::count_if(inliers.begin(), inliers.end(), [&](int i) {
        const auto depths = DepthsOf(pose, matches_[i]);
        return depths && depths->first > 0.0 && depths->second > 0.0;
      });
      if (static_cast<int>(in_front) > most_in_front) {
        most_in_front = static_cast<int>(in_front);
        best = pose;
      }
    }
  }
  return best;
}

}  // namespace cairn
