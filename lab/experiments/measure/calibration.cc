#include "lab/experiments/measure/calibration.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"

namespace cairn {
namespace {

double PositionAccuracyM(const CalibrationSample& sample, const ScoreCalibration& calibration) {
  return std::hypot(calibration.position_accuracy_factor * sample.predicted_position_m,
                    sample.map_accuracy_m);
}

double RotationAccuracyRad(const CalibrationSample& sample, const ScoreCalibration& calibration) {
  return std::hypot(calibration.rotation_accuracy_factor * sample.predicted_rotation_rad,
                    sample.map_accuracy_rad);
}

double ConfidenceOf(const CalibrationSample& sample, const ScoreCalibration& calibration) {
  return calibration.Confidence(sample.score,
                                calibration.position_accuracy_factor * sample.predicted_position_m);
}

constexpr int kMinSamples = 20;
constexpr double kMinSlope = 0.1;
constexpr double kCoverage = 0.68;
constexpr double kMinFactor = 1e-6;
constexpr int kMaxBins = 10;
constexpr int kMinSamplesPerBin = 10;

// A weighted observation of the logistic regression.
struct LogitObservation {
  double log_score = 0.0;
  double outcome = 0.0;  // 0 or 1; in between for several outcomes at once.
  double weight = 1.0;
};

// An error, its predicted radius, and what the map adds.
struct RadiusSample {
  double predicted = 0.0;
  double by_map = 0.0;
  double error = 0.0;
};

void CheckSamples(const std::vector<CalibrationSample>& samples) {
  if (samples.size() < kMinSamples) {
    throw Error(ErrorCode::kInvalidArgument,
                "a calibration needs at least 20 answers with a pose; there are " +
                    std::to_string(samples.size()));
  }
  for (const CalibrationSample& sample : samples) {
    if (!(sample.score > 0.0) || !(sample.predicted_position_m > 0.0) ||
        !(sample.predicted_rotation_rad > 0.0)) {
      throw Error(ErrorCode::kInvalidArgument,
                  "a calibration needs positive scores and predicted accuracies");
    }
  }
}

std::vector<LogitObservation> LogitObservations(const std::vector<CalibrationSample>& samples) {
  std::vector<LogitObservation> observations;
  for (const CalibrationSample& sample : samples) {
    observations.push_back({std::log(sample.score), sample.correct ? 1.0 : 0.0, 1.0});
  }
  const auto middle = observations.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
  std::nth_element(observations.begin(), middle, observations.end(),
                   [](const auto& a, const auto& b) { return a.log_score < b.log_score; });
  observations.push_back({middle->log_score, 0.5, 2.0});
  return observations;
}

double Logistic(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }

double NegativeLogLikelihood(const std::vector<LogitObservation>& observations,
                             const Eigen::Vector2d& slope_and_offset) {
  double sum = 0.0;
  for (const LogitObservation& observation : observations) {
    const double logit = slope_and_offset[0] * observation.log_score + slope_and_offset[1];
    // log(1 + exp(logit)) - outcome * logit, without overflow.
    sum += observation.weight * (std::max(logit, 0.0) + std::log1p(std::exp(-std::abs(logit))) -
                                 observation.outcome * logit);
  }
  return sum;
}

// Uses Newton's method; the problem is convex. Halves steps until they improve the likelihood.
Eigen::Vector2d FitLogistic(const std::vector<LogitObservation>& observations) {
  constexpr int kMaxIterations = 100;
  constexpr double kRidge = 1e-9;
  Eigen::Vector2d x = Eigen::Vector2d::Zero();
  double cost = NegativeLogLikelihood(observations, x);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    Eigen::Matrix2d hessian = kRidge * Eigen::Matrix2d::Identity();
    for (const LogitObservation& observation : observations) {
      const Eigen::Vector2d input(observation.log_score, 1.0);
      const double p = Logistic(x.dot(input));
      gradient += observation.weight * (p - observation.outcome) * input;
      hessian += observation.weight * p * (1.0 - p) * input * input.transpose();
    }
    Eigen::Vector2d step = -hessian.inverse() * gradient;
    double new_cost = NegativeLogLikelihood(observations, x + step);
    while (new_cost > cost && step.norm() > 1e-12) {
      step *= 0.5;
      new_cost = NegativeLogLikelihood(observations, x + step);
    }
    if (!(new_cost < cost)) {
      break;
    }
    x += step;
    cost = new_cost;
  }
  return x;
}

// Returns, for a fixed slope, the offset with which the mean probability equals the observed share.
// Uses bisection.
double FitOffset(const std::vector<LogitObservation>& observations, double slope) {
  double low = -100.0, high = 100.0;
  for (int i = 0; i < 100; ++i) {
    const double offset = 0.5 * (low + high);
    double excess = 0.0;
    for (const LogitObservation& observation : observations) {
      excess += observation.weight *
                (Logistic(slope * observation.log_score + offset) - observation.outcome);
    }
    (excess > 0.0 ? high : low) = offset;
  }
  return 0.5 * (low + high);
}

// Returns the smallest factor with which the radii cover at least kCoverage of the errors. An error
// that the map's accuracy alone covers needs no factor.
double CoverageFactor(const std::vector<RadiusSample>& samples) {
  std::vector<double> factors;
  for (const RadiusSample& sample : samples) {
    const double sq_rest = sample.error * sample.error - sample.by_map * sample.by_map;
    factors.push_back(std::sqrt(std::max(sq_rest, 0.0)) / sample.predicted);
  }
  const auto rank =
      static_cast<std::ptrdiff_t>(std::ceil(kCoverage * static_cast<double>(factors.size())) - 1.0);
  std::nth_element(factors.begin(), factors.begin() + rank, factors.end());
  return std::max(factors[rank], kMinFactor);
}

std::vector<ReliabilityBin> ReliabilityBins(const std::vector<CalibrationSample>& by_score,
                                            const ScoreCalibration& calibration) {
  const auto num_samples = static_cast<int>(by_score.size());
  const int num_bins = std::clamp(num_samples / kMinSamplesPerBin, 1, kMaxBins);
  std::vector<ReliabilityBin> bins;
  for (int bin_idx = 0; bin_idx < num_bins; ++bin_idx) {
    const int begin = num_samples * bin_idx / num_bins;
    const int end = num_samples * (bin_idx + 1) / num_bins;
    ReliabilityBin bin;
    bin.num_samples = end - begin;
    int num_correct = 0;
    for (int i = begin; i < end; ++i) {
      bin.mean_confidence += ConfidenceOf(by_score[i], calibration) / bin.num_samples;
      num_correct += by_score[i].correct ? 1 : 0;
    }
    bin.share_correct = WilsonInterval(num_correct, bin.num_samples);
    bins.push_back(bin);
  }
  return bins;
}

}  // namespace

std::vector<CalibrationSample> CalibrationSamples(const EvalReport& report,
                                                  const ScoreCalibration& used) {
  std::vector<CalibrationSample> samples;
  for (const EvalAnswer& answer : report.answers) {
    if (answer.result.localized) {
      const LocalizeResult& result = answer.result;
      samples.push_back(
          {.score = result.score,
           .correct = IsWithin(answer, kCorrect),
           .position_error_m = answer.position_error_m,
           .rotation_error_rad = answer.rotation_error_rad,
           .predicted_position_m = result.position_accuracy_m / used.position_accuracy_factor,
           .predicted_rotation_rad = result.rotation_accuracy_rad / used.rotation_accuracy_factor,
           .map_accuracy_m = result.map_accuracy_m,
           .map_accuracy_rad = result.map_accuracy_rad});
    }
  }
  return samples;
}

ScoreCalibration FitCalibration(const std::vector<CalibrationSample>& samples) {
  CheckSamples(samples);
  const std::vector<LogitObservation> observations = LogitObservations(samples);
  Eigen::Vector2d slope_and_offset = FitLogistic(observations);
  if (!(slope_and_offset[0] >= kMinSlope)) {
    slope_and_offset = {kMinSlope, FitOffset(observations, kMinSlope)};
  }
  std::vector<RadiusSample> positions, rotations;
  for (const CalibrationSample& sample : samples) {
    positions.push_back(
        {sample.predicted_position_m, sample.map_accuracy_m, sample.position_error_m});
    rotations.push_back(
        {sample.predicted_rotation_rad, sample.map_accuracy_rad, sample.rotation_error_rad});
  }
  return {.confidence_slope = slope_and_offset[0],
          .confidence_offset = slope_and_offset[1],
          .position_accuracy_factor = CoverageFactor(positions),
          .rotation_accuracy_factor = CoverageFactor(rotations)};
}

CalibrationReport MeasureCalibration(const std::vector<CalibrationSample>& samples,
                                     const ScoreCalibration& calibration) {
  if (samples.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                "no answer has a pose, so there is nothing to measure");
  }
  std::vector<CalibrationSample> by_score = samples;
  std::stable_sort(by_score.begin(), by_score.end(),
                   [](const auto& a, const auto& b) { return a.score < b.score; });
  CalibrationReport report;
  report.num_samples = static_cast<int>(samples.size());
  report.bins = ReliabilityBins(by_score, calibration);
  for (const ReliabilityBin& bin : report.bins) {
    report.expected_calibration_error += std::abs(bin.mean_confidence - bin.share_correct.value) *
                                         bin.num_samples / report.num_samples;
  }
  int num_position_within = 0, num_rotation_within = 0;
  for (const CalibrationSample& sample : samples) {
    const double miss = ConfidenceOf(sample, calibration) - (sample.correct ? 1.0 : 0.0);
    report.brier_score += miss * miss / report.num_samples;
    num_position_within += sample.position_error_m <= PositionAccuracyM(sample, calibration);
    num_rotation_within += sample.rotation_error_rad <= RotationAccuracyRad(sample, calibration);
  }
  report.position_coverage = WilsonInterval(num_position_within, report.num_samples);
  report.rotation_coverage = WilsonInterval(num_rotation_within, report.num_samples);
  return report;
}

}  // namespace cairn
