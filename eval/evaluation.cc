#include "eval/evaluation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/angles.h"
#include "core/check.h"
#include "core/statistics.h"
#include "eval/evaluation_measures.h"

namespace cairn {
namespace {

constexpr RecallThreshold kRecallThresholds[] = {
    {0.25, 2.0 * kRadPerDeg}, {0.5, 5.0 * kRadPerDeg}, kCorrect, {5.0, 10.0 * kRadPerDeg}};

EvalAnswer CompareToReference(const EvalQuery& query, LocalizeResult result) {
  EvalAnswer answer;
  answer.name = query.name;
  answer.result = std::move(result);
  if (answer.result.localized) {
    const Rigid3d& estimated = answer.result.cam_from_ecef;
    answer.position_error_m =
        (estimated.Inverse().translation - query.cam_from_ecef.Inverse().translation).norm();
    answer.rotation_error_rad = RotationAngleRad(estimated.rotation, query.cam_from_ecef.rotation);
    const bool on_earth = query.reference_frame == ReferenceFrame::kEarth;
    answer.position_accuracy_m =
        on_earth ? answer.result.EarthAccuracyM() : answer.result.position_accuracy_m;
    answer.rotation_accuracy_rad =
        on_earth ? answer.result.EarthAccuracyRad() : answer.result.rotation_accuracy_rad;
  } else {
    answer.position_error_m = std::numeric_limits<double>::infinity();
    answer.rotation_error_rad = std::numeric_limits<double>::infinity();
  }
  return answer;
}

Percentiles ComputePercentiles(std::vector<double> values) {
  if (values.empty()) {
    return {};
  }
  return {Quantile(values, 0.5), Quantile(values, 0.9), Quantile(values, 0.99),
          Quantile(values, 1.0)};
}

void MeasureLatency(EvalReport* report) {
  report->stage_seconds.clear();
  for (int stage = 0; stage < kNumStages; ++stage) {
    std::vector<double> seconds;
    for (const EvalAnswer& answer : report->answers) {
      seconds.push_back(answer.result.times.seconds[stage]);
    }
    report->stage_seconds.push_back(ComputePercentiles(std::move(seconds)));
  }
  std::vector<double> total_seconds;
  for (const EvalAnswer& answer : report->answers) {
    total_seconds.push_back(answer.result.times.total_seconds);
  }
  report->total_seconds = ComputePercentiles(std::move(total_seconds));
}

// An error is the distance between two poses, of which both are wrong.
void MeasureCoverage(const std::vector<EvalQuery>& queries, EvalReport* report) {
  int num_positions = 0, num_rotations = 0;
  for (size_t i = 0; i < queries.size(); ++i) {
    const EvalQuery& query = queries[i];
    const EvalAnswer& answer = report->answers[i];
    if (answer.result.localized) {
      num_positions += answer.position_error_m <=
                       std::hypot(answer.position_accuracy_m, query.reference_radius_m);
      num_rotations += answer.rotation_error_rad <=
                       std::hypot(answer.rotation_accuracy_rad, query.reference_radius_rad);
    }
  }
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const auto share = [&](int count) {
    return report->num_localized > 0 ? WilsonInterval(count, report->num_localized)
                                     : Interval{kNone, kNone, kNone};
  };
  report->position_coverage = share(num_positions);
  report->rotation_coverage = share(num_rotations);
}

void MeasureAccuracyOf(EvalReport* report) {
  const std::vector<EvalAnswer>& answers = report->answers;
  for (const RecallThreshold& threshold : kRecallThresholds) {
    report->recalls.emplace_back(threshold,
                                 Bootstrap(answers.size(), [&](std::span<const size_t> sample) {
                                   return RecallOf(answers, sample, threshold);
                                 }));
  }
  report->median_position_error_m = Bootstrap(answers.size(), [&](std::span<const size_t> sample) {
    return MedianOfLocalized(answers, sample, &EvalAnswer::position_error_m);
  });
  report->median_rotation_error_rad =
      Bootstrap(answers.size(), [&](std::span<const size_t> sample) {
        return MedianOfLocalized(answers, sample, &EvalAnswer::rotation_error_rad);
      });
  report->average_precision = Bootstrap(answers.size(), [&](std::span<const size_t> sample) {
    return AveragePrecisionOf(answers, sample);
  });
  std::vector<size_t> all(answers.size());
  std::iota(all.begin(), all.end(), size_t{0});
  report->precision_recall =
      PrecisionRecallCurve(RankedResponses(answers, all), report->num_queries);
}

}  // namespace

EvalReport MeasureResults(const std::vector<EvalQuery>& queries,
                          std::vector<LocalizeResult> results) {
  CAIRN_CHECK(queries.size() == results.size(), "one result a query");
  EvalReport report;
  report.num_queries = static_cast<int>(queries.size());
  for (size_t i = 0; i < queries.size(); ++i) {
    report.num_localized += results[i].localized ? 1 : 0;
    report.answers.push_back(CompareToReference(queries[i], std::move(results[i])));
  }
  MeasureAccuracyOf(&report);
  MeasureCoverage(queries, &report);
  MeasureLatency(&report);
  return report;
}

EvalReport Evaluate(const std::vector<EvalQuery>& queries, const Localize& localize,
                    const std::function<void(int done, int total)>& progress) {
  std::vector<LocalizeResult> results;
  results.reserve(queries.size());
  for (const EvalQuery& query : queries) {
    results.push_back(localize(query));
    if (progress) {
      progress(static_cast<int>(results.size()), static_cast<int>(queries.size()));
    }
  }
  return MeasureResults(queries, std::move(results));
}

}  // namespace cairn
