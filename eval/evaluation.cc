#include "eval/evaluation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/check.h"

namespace cairn {
namespace {

constexpr double kRadFromDeg = 0.017453292519943295;
constexpr RecallThreshold kRecallThresholds[] = {{0.25, 2.0 * kRadFromDeg},
                                                 {0.5, 5.0 * kRadFromDeg},
                                                 {3.0, 10.0 * kRadFromDeg},
                                                 {5.0, 10.0 * kRadFromDeg}};
// What counts as correct in the average precision.
constexpr RecallThreshold kCorrect = {3.0, 10.0 * kRadFromDeg};

constexpr int kNumResamplings = 1000;
constexpr uint64_t kBootstrapSeed = 1;

bool IsWithin(const EvalAnswer& answer, const RecallThreshold& threshold) {
  return answer.result.localized && answer.position_error_m <= threshold.position_m &&
         answer.rotation_error_rad <= threshold.rotation_rad;
}

EvalAnswer CompareToReference(const EvalQuery& query, LocalizeResult result) {
  EvalAnswer answer;
  answer.name = query.name;
  answer.result = std::move(result);
  if (answer.result.localized) {
    const Rigid3d& estimated = answer.result.cam_from_ecef;
    answer.position_error_m =
        (estimated.Inverse().translation - query.cam_from_ecef.Inverse().translation).norm();
    answer.rotation_error_rad = RotationAngleRad(estimated.rotation, query.cam_from_ecef.rotation);
  } else {
    answer.position_error_m = std::numeric_limits<double>::infinity();
    answer.rotation_error_rad = std::numeric_limits<double>::infinity();
  }
  return answer;
}

// `share` in [0, 1]; linear between ranks. Sorts `values`, which must not be empty.
double Quantile(std::vector<double>* values, double share) {
  std::sort(values->begin(), values->end());
  const double rank = share * static_cast<double>(values->size() - 1);
  const auto lower = static_cast<size_t>(rank);
  const size_t upper = std::min(lower + 1, values->size() - 1);
  const double fraction = rank - static_cast<double>(lower);
  return (*values)[lower] + fraction * ((*values)[upper] - (*values)[lower]);
}

Percentiles ComputePercentiles(std::vector<double> values) {
  if (values.empty()) {
    return {};
  }
  return {Quantile(&values, 0.5), Quantile(&values, 0.9), Quantile(&values, 0.99),
          Quantile(&values, 1.0)};
}

using Sample = std::vector<const EvalAnswer*>;
using Statistic = std::function<double(const Sample&)>;  // Not a number if undefined.

// Percentile bootstrap. The same resamplings for every statistic of a report.
Interval Bootstrap(const std::vector<EvalAnswer>& answers, const Statistic& statistic) {
  Sample all;
  for (const EvalAnswer& answer : answers) {
    all.push_back(&answer);
  }
  Interval interval;
  interval.value = interval.low = interval.high = statistic(all);
  if (std::isnan(interval.value)) {
    return interval;
  }
  std::mt19937_64 generator(kBootstrapSeed);
  std::uniform_int_distribution<size_t> draw(0, answers.size() - 1);
  Sample sample(answers.size());
  std::vector<double> values;
  for (int i = 0; i < kNumResamplings; ++i) {
    std::generate(sample.begin(), sample.end(), [&] { return &answers[draw(generator)]; });
    if (const double value = statistic(sample); !std::isnan(value)) {
      values.push_back(value);
    }
  }
  if (!values.empty()) {
    interval.low = Quantile(&values, 0.025);
    interval.high = Quantile(&values, 0.975);
  }
  return interval;
}

double Recall(const Sample& sample, const RecallThreshold& threshold) {
  if (sample.empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const auto num_within =
      std::count_if(sample.begin(), sample.end(),
                    [&](const EvalAnswer* answer) { return IsWithin(*answer, threshold); });
  return static_cast<double>(num_within) / static_cast<double>(sample.size());
}

double MedianOfLocalized(const Sample& sample, double EvalAnswer::*error) {
  std::vector<double> errors;
  for (const EvalAnswer* answer : sample) {
    if (answer->result.localized) {
      errors.push_back(answer->*error);
    }
  }
  return errors.empty() ? std::numeric_limits<double>::quiet_NaN() : Quantile(&errors, 0.5);
}

double AveragePrecisionOf(const Sample& sample) {
  if (sample.empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  std::vector<std::pair<double, bool>> score_and_correct;
  for (const EvalAnswer* answer : sample) {
    if (answer->result.localized) {
      score_and_correct.emplace_back(answer->result.score, IsWithin(*answer, kCorrect));
    }
  }
  return AveragePrecision(score_and_correct, static_cast<int>(sample.size()));
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

void MeasureAccuracy(EvalReport* report) {
  const std::vector<EvalAnswer>& answers = report->answers;
  for (const RecallThreshold& threshold : kRecallThresholds) {
    report->recalls.emplace_back(threshold, Bootstrap(answers, [&](const Sample& sample) {
                                   return Recall(sample, threshold);
                                 }));
  }
  report->median_position_error_m = Bootstrap(answers, [](const Sample& sample) {
    return MedianOfLocalized(sample, &EvalAnswer::position_error_m);
  });
  report->median_rotation_error_rad = Bootstrap(answers, [](const Sample& sample) {
    return MedianOfLocalized(sample, &EvalAnswer::rotation_error_rad);
  });
  report->average_precision = Bootstrap(answers, AveragePrecisionOf);
}

}  // namespace

double AveragePrecision(const std::vector<std::pair<double, bool>>& score_and_correct,
                        int num_queries) {
  CAIRN_CHECK(num_queries >= static_cast<int>(score_and_correct.size()),
              "more responses than queries");
  std::vector<std::pair<double, bool>> ranked = score_and_correct;
  std::sort(ranked.begin(), ranked.end(),
            [](const auto& p, const auto& q) { return p.first > q.first; });
  double area = 0.0;
  int num_accepted = 0, num_correct = 0;
  while (num_accepted < static_cast<int>(ranked.size())) {
    const double score = ranked[num_accepted].first;
    const int num_correct_before = num_correct;
    while (num_accepted < static_cast<int>(ranked.size()) && ranked[num_accepted].first == score) {
      num_correct += ranked[num_accepted].second ? 1 : 0;
      ++num_accepted;
    }
    const double precision = static_cast<double>(num_correct) / num_accepted;
    area += precision * (num_correct - num_correct_before) / num_queries;
  }
  return area;
}

EvalReport MeasureResults(const std::vector<EvalQuery>& queries,
                          std::vector<LocalizeResult> results) {
  CAIRN_CHECK(queries.size() == results.size(), "one result a query");
  EvalReport report;
  report.num_queries = static_cast<int>(queries.size());
  for (size_t i = 0; i < queries.size(); ++i) {
    report.num_localized += results[i].localized ? 1 : 0;
    report.answers.push_back(CompareToReference(queries[i], std::move(results[i])));
  }
  MeasureAccuracy(&report);
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
