#include "ingest/anchor/bending.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/radius68.h"

namespace cairn {
namespace {

constexpr double kSqrt3 = 1.7320508075688772;
// A standard deviation that no pose falls below.
constexpr double kLeastSigmaM = 0.005;
constexpr double kLeastSigmaRad = 2e-4;
// Values that decide how the field varies; more would not change it and take cubic time.
constexpr size_t kMaxDeciding = 100;

// Matern's covariance of smoothness 3/2, of a drift that changes its direction without jumps.
double Correlation(double distance_m, double wave_m) {
  const double x = kSqrt3 * distance_m / wave_m;
  return (1.0 + x) * std::exp(-x);
}

struct Samples {
  std::vector<Eigen::Vector3d> places;
  Eigen::MatrixX3d values;
  Eigen::VectorXd variances;

  Eigen::Index size() const { return values.rows(); }
};

struct Shape {
  double amplitude = 0.0;
  double wave_m = 1.0;
  double extra_sigma = 0.0;  // Of each value, beside its own.
};

Eigen::MatrixXd CorrelationsOf(const Samples& samples, double wave_m) {
  Eigen::MatrixXd correlations(samples.size(), samples.size());
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      const double distance_m =
          (samples.places[static_cast<size_t>(i)] - samples.places[static_cast<size_t>(j)]).norm();
      correlations(i, j) = correlations(j, i) = Correlation(distance_m, wave_m);
    }
  }
  return correlations;
}

Eigen::MatrixXd CovarianceOf(const Samples& samples, const Eigen::MatrixXd& correlations,
                             const Shape& shape) {
  Eigen::MatrixXd covariance = shape.amplitude * shape.amplitude * correlations;
  covariance.diagonal() += samples.variances;
  covariance.diagonal().array() += shape.extra_sigma * shape.extra_sigma;
  return covariance;
}

// Logarithm of the likelihood of the values, without the constant.
double LogLikelihood(const Samples& samples, const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  const Eigen::MatrixX3d whitened = factor.matrixL().solve(samples.values);
  return -0.5 * whitened.squaredNorm() - 3.0 * factor.matrixLLT().diagonal().array().log().sum();
}

// Each step is a factor of two, which changes the result little.
std::optional<Shape> MostLikelyShape(const Samples& samples, double unit) {
  Shape best;
  double best_of_none = -1e300, best_of_all = -1e300;
  for (const double wave_m : {10.0, 20.0, 40.0, 80.0, 160.0, 320.0}) {
    const Eigen::MatrixXd correlations = CorrelationsOf(samples, wave_m);
    for (const double amplitude : {0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0}) {
      if (amplitude == 0.0 && wave_m > 10.0) {
        continue;  // The same for all waves.
      }
      for (const double extra : {0.0, 0.5, 1.0, 2.0, 4.0}) {
        const Shape shape = {amplitude * unit, wave_m, extra * unit};
        const double likelihood =
            LogLikelihood(samples, CovarianceOf(samples, correlations, shape));
        if (amplitude == 0.0) {
          best_of_none = std::max(best_of_none, likelihood);
        }
        if (likelihood > best_of_all) {
          best_of_all = likelihood;
          best = shape;
        }
      }
    }
  }
  // Schwarz's criterion: two parameters more have to explain this much.
  const double needed = std::log(3.0 * static_cast<double>(samples.size()));
  return best.amplitude > 0.0 && best_of_all - best_of_none > needed ? std::optional(best)
                                                                     : std::nullopt;
}

Samples EveryNth(const Samples& samples) {
  const auto count = static_cast<size_t>(samples.size());
  if (count <= kMaxDeciding) {
    return samples;
  }
  Samples some;
  some.values.resize(kMaxDeciding, 3);
  some.variances.resize(kMaxDeciding);
  for (size_t k = 0; k < kMaxDeciding; ++k) {
    const size_t i = count * k / kMaxDeciding;
    some.places.push_back(samples.places[i]);
    some.values.row(static_cast<Eigen::Index>(k)) =
        samples.values.row(static_cast<Eigen::Index>(i));
    some.variances[static_cast<Eigen::Index>(k)] = samples.variances[static_cast<Eigen::Index>(i)];
  }
  return some;
}

struct Regression {
  Eigen::MatrixX3d weights;    // Of the correlations with each sample.
  Eigen::MatrixX3d surprises;  // Each value minus what the others tell about it.
};

// The variances grow where values contradict their neighbors, with Cauchy's weights at two standard
// deviations.
Regression Regress(const Shape& shape, Samples* samples) {
  constexpr int kRounds = 4;
  constexpr double kScaleSigmas = 2.0;
  const Eigen::MatrixXd correlations = CorrelationsOf(*samples, shape.wave_m);
  const Eigen::VectorXd variances = samples->variances;
  Regression regression;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::MatrixXd inverse =
        CovarianceOf(*samples, correlations, shape)
            .llt()
            .solve(Eigen::MatrixXd::Identity(samples->size(), samples->size()));
    const Eigen::MatrixX3d solved = inverse * samples->values;
    regression.weights = shape.amplitude * shape.amplitude * solved;
    regression.surprises = inverse.diagonal().cwiseInverse().asDiagonal() * solved;
    for (Eigen::Index i = 0; i < samples->size(); ++i) {
      const double own = variances[i] + shape.extra_sigma * shape.extra_sigma;
      // The variance of a surprise with the value's own variance instead of the inflated one.
      const double expected = 1.0 / inverse(i, i) - samples->variances[i] + variances[i];
      const double chi_sq = regression.surprises.row(i).squaredNorm() / (3.0 * expected);
      samples->variances[i] = variances[i] + own * chi_sq / (kScaleSigmas * kScaleSigmas);
    }
  }
  return regression;
}

}  // namespace

DriftField DriftField::Fit(const std::vector<Eigen::Vector3d>& places,
                           const std::vector<Eigen::Vector3d>& values,
                           const std::vector<double>& sigmas, double unit) {
  Samples samples;
  samples.places = places;
  samples.values.resize(static_cast<Eigen::Index>(values.size()), 3);
  samples.variances.resize(static_cast<Eigen::Index>(values.size()));
  for (size_t i = 0; i < values.size(); ++i) {
    samples.values.row(static_cast<Eigen::Index>(i)) = values[i].transpose();
    samples.variances[static_cast<Eigen::Index>(i)] = sigmas[i] * sigmas[i];
  }
  DriftField field;
  const std::optional<Shape> shape =
      values.empty() ? std::nullopt : MostLikelyShape(EveryNth(samples), unit);
  if (!shape) {
    return field;
  }
  const Regression regression = Regress(*shape, &samples);
  field.amplitude_ = shape->amplitude;
  field.wave_m_ = shape->wave_m;
  field.places_ = places;
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    field.weights_.emplace_back(regression.weights.row(i).transpose());
    field.surprises_.emplace_back(regression.surprises.row(i).transpose());
  }
  return field;
}

Eigen::Vector3d DriftField::At(const Eigen::Vector3d& place) const {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < places_.size(); ++i) {
    value += Correlation((place - places_[i]).norm(), wave_m_) * weights_[i];
  }
  return value;
}

Bending Bending::Fit(const std::vector<PosePair>& pairs) {
  constexpr double kUnitM = 0.02;
  constexpr double kUnitRad = 5e-4;
  std::vector<Eigen::Vector3d> places, shifts, turns;
  std::vector<double> sigmas_m, sigmas_rad;
  for (const PosePair& pair : pairs) {
    const Rigid3d ecef_from_cam = pair.cam_from_ecef.Inverse();
    const Rigid3d in_map = pair.cam_from_ecef_in_map.Inverse();
    places.push_back(ecef_from_cam.translation);
    shifts.push_back(in_map.translation - ecef_from_cam.translation);
    turns.push_back(LogSo3(in_map.rotation * ecef_from_cam.rotation.conjugate()));
    sigmas_m.push_back(std::max(kLeastSigmaM, pair.accuracy_m / kRadius68PerSigma3d));
    sigmas_rad.push_back(std::max(kLeastSigmaRad, pair.accuracy_rad / kRadius68PerSigma3d));
  }
  Bending bending;
  bending.shift_ = DriftField::Fit(places, shifts, sigmas_m, kUnitM);
  bending.turn_ = DriftField::Fit(places, turns, sigmas_rad, kUnitRad);
  return bending;
}

Rigid3d Bending::Bend(const Rigid3d& cam_from_ecef) const {
  if (is_none()) {
    return cam_from_ecef;
  }
  const Rigid3d ecef_from_cam = cam_from_ecef.Inverse();
  const Eigen::Vector3d& center = ecef_from_cam.translation;
  return Rigid3d(ExpSo3(turn_.At(center)) * ecef_from_cam.rotation, center + shift_.At(center))
      .Inverse();
}

}  // namespace cairn
