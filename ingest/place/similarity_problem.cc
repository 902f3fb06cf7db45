#include "ingest/place/similarity_problem.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "core/adjust/quiet_ceres.h"
#include "core/error.h"
#include "core/random.h"
#include "core/rotation_between.h"

namespace cairn {
namespace {

constexpr int kNumSamples = 300;  // Of each kind of sample.
constexpr uint64_t kSampleSeed = 1;
// Scales outside these limits come from degenerate samples.
constexpr double kMinScale = 1e-6, kMaxScale = 1e6;
// Weight of horizontal forward axes relative to horizontal x axes. It decides the vertical only if
// all x axes are parallel.
constexpr double kForwardWeight = 0.02;

// The unknowns in the form that Ceres changes.
struct Parameters {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d translation;
  double log_scale;
};

class PositionResidual {
 public:
  explicit PositionResidual(const SimilarityProblem::Position& position) : position_(position) {}

  template <typename T>
  bool operator()(const T* rotation, const T* translation, const T* log_scale, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> enu_from_world(rotation);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> offset(translation);
    Eigen::Map<Eigen::Matrix<T, 3, 1>> out(residual);
    const Eigen::Matrix<T, 3, 1> turned = enu_from_world * position_.center_in_world.cast<T>();
    out = (exp(log_scale[0]) * turned + offset - position_.center_in_enu.cast<T>()) /
          T(position_.accuracy_m);
    out.z() *= T(position_.accuracy_m / position_.height_accuracy_m);
    return true;
  }

 private:
  SimilarityProblem::Position position_;
};

class UprightResidual {
 public:
  UprightResidual(const Eigen::Vector3d& right_in_world, double sigma_rad)
      : right_in_world_(right_in_world), sigma_rad_(sigma_rad) {}

  template <typename T>
  bool operator()(const T* rotation, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> enu_from_world(rotation);
    const Eigen::Matrix<T, 3, 1> right_in_enu = enu_from_world * right_in_world_.cast<T>();
    residual[0] = right_in_enu.z() / T(sigma_rad_);
    return true;
  }

 private:
  Eigen::Vector3d right_in_world_;
  double sigma_rad_;
};

class UpResidual {
 public:
  explicit UpResidual(const Eigen::Vector3d& up_in_world) : up_in_world_(up_in_world) {}

  template <typename T>
  bool operator()(const T* rotation, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> enu_from_world(rotation);
    const Eigen::Matrix<T, 3, 1> up_in_enu = enu_from_world * up_in_world_.cast<T>();
    residual[0] = up_in_enu.x() / T(kUpSigmaRad);
    residual[1] = up_in_enu.y() / T(kUpSigmaRad);
    return true;
  }

 private:
  Eigen::Vector3d up_in_world_;
};

bool IsUsable(const Sim3d& similarity) {
  return std::isfinite(similarity.scale) && similarity.scale > kMinScale &&
         similarity.scale < kMaxScale && similarity.translation.allFinite() &&
         similarity.rotation.coeffs().allFinite();
}

// The direction closest to perpendicular to the level axes of all cameras.
Eigen::Vector3d UpFromCameras(const SimilarityProblem& problem) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& right : problem.right_in_world) {
    const Eigen::Vector3d forward = right.cross(-problem.mean_up_in_world);
    scatter += right * right.transpose() + kForwardWeight * forward * forward.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  const Eigen::Vector3d up = solver.eigenvectors().col(0);
  return up.dot(problem.mean_up_in_world) < 0.0 ? Eigen::Vector3d(-up) : up;
}

// The similarity that applies `level_from_world` and then a yaw, and that maps positions a and b
// exactly in the horizontal plane. Returns nothing if both are at the same place.
std::optional<Sim3d> FromTwoPositions(const SimilarityProblem::Position& a,
                                      const SimilarityProblem::Position& b,
                                      const Eigen::Quaterniond& level_from_world) {
  const Eigen::Vector3d across_level = level_from_world * (b.center_in_world - a.center_in_world);
  const Eigen::Vector3d across_enu = b.center_in_enu - a.center_in_enu;
  const double level_length = across_level.head<2>().norm();
  const double enu_length = across_enu.head<2>().norm();
  if (!(level_length > 0.0) || !(enu_length > 0.0)) {
    return std::nullopt;
  }
  const double yaw_rad =
      std::atan2(across_enu.y(), across_enu.x()) - std::atan2(across_level.y(), across_level.x());
  Sim3d enu_from_world;
  enu_from_world.scale = enu_length / level_length;
  enu_from_world.rotation = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) * level_from_world;
  enu_from_world.translation =
      0.5 * (a.center_in_enu + b.center_in_enu) -
      enu_from_world.scale *
          (enu_from_world.rotation * (0.5 * (a.center_in_world + b.center_in_world)));
  return enu_from_world;
}

// Unless `lines_too`, returns nothing if the three positions are (nearly) collinear in either
// frame.
std::optional<Sim3d> FromThreePositions(const std::array<SimilarityProblem::Position, 3>& sample,
                                        bool lines_too) {
  Eigen::Matrix3d world, enu;
  for (int i = 0; i < 3; ++i) {
    world.col(i) = sample[i].center_in_world;
    enu.col(i) = sample[i].center_in_enu;
  }
  const auto is_line = [](const Eigen::Matrix3d& p) {
    const Eigen::Vector3d a = p.col(1) - p.col(0), b = p.col(2) - p.col(0);
    return !(a.cross(b).norm() > 1e-3 * a.norm() * b.norm());
  };
  if (!lines_too && (is_line(world) || is_line(enu))) {
    return std::nullopt;
  }
  const Eigen::Matrix4d matrix = Eigen::umeyama(world, enu, /*with_scaling=*/true);
  Sim3d enu_from_world;
  enu_from_world.scale = std::cbrt(matrix.topLeftCorner<3, 3>().determinant());
  enu_from_world.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(matrix.topLeftCorner<3, 3>() / enu_from_world.scale));
  enu_from_world.rotation.normalize();
  enu_from_world.translation = matrix.topRightCorner<3, 1>();
  return enu_from_world;
}

// Keeps the cheapest of the similarities offered to it.
class Cheapest {
 public:
  explicit Cheapest(const SimilarityProblem* problem) : problem_(problem) {}

  void Consider(const std::optional<Sim3d>& candidate) {
    if (!candidate || !IsUsable(*candidate)) {
      return;
    }
    const std::optional<Eigen::Vector3d>& up_in_world = problem_->up_in_world;
    if (up_in_world && (candidate->rotation * *up_in_world).z() < std::sqrt(0.5)) {
      return;
    }
    const double cost = problem_->Cost(*candidate);
    if (cost < best_cost_) {
      best_ = *candidate;
      best_cost_ = cost;
    }
  }

  std::optional<Sim3d> best() const {
    return std::isfinite(best_cost_) ? std::optional<Sim3d>(best_) : std::nullopt;
  }

 private:
  const SimilarityProblem* problem_;
  Sim3d best_;
  double best_cost_ = std::numeric_limits<double>::infinity();
};

}  // namespace

double SqResidual(const SimilarityProblem::Position& position,
                  const Eigen::Vector3d& error_in_enu) {
  const double height = error_in_enu.z() / position.height_accuracy_m;
  return error_in_enu.head<2>().squaredNorm() / (position.accuracy_m * position.accuracy_m) +
         height * height;
}

double SimilarityProblem::Cost(const Sim3d& enu_from_world) const {
  const double sq_scale = kLossScaleSigmas * kLossScaleSigmas;
  const auto loss = [&](double sq_residual) {
    return sq_scale * std::log1p(sq_residual / sq_scale);
  };
  double cost = 0.0;
  for (const Position& position : positions) {
    const Eigen::Vector3d error =
        enu_from_world * position.center_in_world - position.center_in_enu;
    cost += loss(SqResidual(position, error));
  }
  if (upright_sigma_rad > 0.0) {
    const Eigen::Vector3d up_in_world =
        enu_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    for (const Eigen::Vector3d& right : right_in_world) {
      const double residual = right.dot(up_in_world) / upright_sigma_rad;
      cost += loss(residual * residual);
    }
  }
  if (up_in_world) {
    cost += (enu_from_world.rotation * *up_in_world).head<2>().squaredNorm() /
            (kUpSigmaRad * kUpSigmaRad);
  }
  return cost;
}

Sim3d LooseSimilarity(const std::vector<SimilarityProblem::Position>& positions) {
  SimilarityProblem problem;
  problem.positions = positions;
  std::mt19937_64 rng(kSampleSeed);
  const auto draw = [&] { return positions[UniformIndex(positions.size(), &rng)]; };
  Cheapest cheapest(&problem);
  for (int i = 0; i < kNumSamples; ++i) {
    cheapest.Consider(FromThreePositions({draw(), draw(), draw()}, /*lines_too=*/true));
  }
  return cheapest.best().value_or(Sim3d());
}

std::optional<Sim3d> InitialSimilarity(const SimilarityProblem& problem) {
  std::mt19937_64 rng(kSampleSeed);
  const auto draw = [&] { return problem.positions[UniformIndex(problem.positions.size(), &rng)]; };
  Cheapest cheapest(&problem);
  if (problem.upright_sigma_rad > 0.0 && problem.mean_up_in_world.norm() > 1e-3) {
    const Eigen::Quaterniond level_from_world =
        RotationBetween(UpFromCameras(problem), Eigen::Vector3d::UnitZ());
    for (int i = 0; i < kNumSamples; ++i) {
      cheapest.Consider(FromTwoPositions(draw(), draw(), level_from_world));
    }
  }
  for (int i = 0; i < kNumSamples; ++i) {
    cheapest.Consider(FromThreePositions({draw(), draw(), draw()}, /*lines_too=*/false));
  }
  return cheapest.best();
}

Sim3d RefineSimilarity(const SimilarityProblem& problem, const Sim3d& start) {
  Parameters parameters{start.rotation, start.translation, std::log(start.scale)};
  ceres::Problem ceres_problem;
  for (const SimilarityProblem::Position& position : problem.positions) {
    ceres_problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PositionResidual, 3, 4, 3, 1>(
                                       new PositionResidual(position)),
                                   new ceres::CauchyLoss(kLossScaleSigmas),
                                   parameters.rotation.coeffs().data(),
                                   parameters.translation.data(), &parameters.log_scale);
  }
  if (problem.upright_sigma_rad > 0.0) {
    for (const Eigen::Vector3d& right : problem.right_in_world) {
      ceres_problem.AddResidualBlock(new ceres::AutoDiffCostFunction<UprightResidual, 1, 4>(
                                         new UprightResidual(right, problem.upright_sigma_rad)),
                                     new ceres::CauchyLoss(kLossScaleSigmas),
                                     parameters.rotation.coeffs().data());
    }
  }
  if (problem.up_in_world) {
    ceres_problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<UpResidual, 2, 4>(new UpResidual(*problem.up_in_world)),
        nullptr, parameters.rotation.coeffs().data());
  }
  ceres_problem.SetManifold(parameters.rotation.coeffs().data(),
                            new ceres::EigenQuaternionManifold);
  ceres::Solver::Options options = QuietCeresOptions();
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  if (!summary.IsSolutionUsable()) {
    throw Error(ErrorCode::kInternal,
                fmt::format("georegistration did not converge: {}", summary.message));
  }
  return {std::exp(parameters.log_scale), parameters.rotation.normalized(), parameters.translation};
}

}  // namespace cairn
