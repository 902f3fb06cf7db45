#include "eval/evaluation_measures.h"

#include <algorithm>
#include <limits>

#include "core/check.h"
#include "core/statistics.h"

namespace cairn {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

bool IsWithin(const EvalAnswer& answer, const RecallThreshold& threshold) {
  return answer.result.localized && answer.position_error_m <= threshold.position_m &&
         answer.rotation_error_rad <= threshold.rotation_rad;
}

double RecallOf(const std::vector<EvalAnswer>& answers, std::span<const size_t> sample,
                const RecallThreshold& threshold) {
  const auto num_within = std::count_if(sample.begin(), sample.end(),
                                        [&](size_t i) { return IsWithin(answers[i], threshold); });
  return sample.empty() ? kNaN
                        : static_cast<double>(num_within) / static_cast<double>(sample.size());
}

double MedianOfLocalized(const std::vector<EvalAnswer>& answers, std::span<const size_t> sample,
                         double EvalAnswer::*error) {
  std::vector<double> errors;
  for (const size_t i : sample) {
    if (answers[i].result.localized) {
      errors.push_back(answers[i].*error);
    }
  }
  return errors.empty() ? kNaN : Quantile(std::move(errors), 0.5);
}

std::vector<std::pair<double, bool>> RankedResponses(const std::vector<EvalAnswer>& answers,
                                                     std::span<const size_t> sample) {
  std::vector<std::pair<double, bool>> responses;
  for (const size_t i : sample) {
    if (answers[i].result.localized) {
      responses.emplace_back(answers[i].result.score, IsWithin(answers[i], kCorrect));
    }
  }
  return responses;
}

double AveragePrecisionOf(const std::vector<EvalAnswer>& answers, std::span<const size_t> sample) {
  return sample.empty()
             ? kNaN
             : AveragePrecision(RankedResponses(answers, sample), static_cast<int>(sample.size()));
}

std::vector<PrecisionRecallPoint> PrecisionRecallCurve(
    const std::vector<std::pair<double, bool>>& score_and_correct, int num_queries) {
  CAIRN_CHECK(num_queries >= static_cast<int>(score_and_correct.size()),
              "more responses than queries");
  std::vector<std::pair<double, bool>> ranked = score_and_correct;
  std::sort(ranked.begin(), ranked.end(),
            [](const auto& p, const auto& q) { return p.first > q.first; });
  std::vector<PrecisionRecallPoint> curve;
  int num_correct = 0;
  for (size_t i = 0; i < ranked.size(); ++i) {
    num_correct += ranked[i].second ? 1 : 0;
    if (i + 1 == ranked.size() || ranked[i + 1].first != ranked[i].first) {
      curve.push_back({ranked[i].first, num_correct / static_cast<double>(i + 1),
                       num_correct / static_cast<double>(num_queries)});
    }
  }
  return curve;
}

double AveragePrecision(const std::vector<std::pair<double, bool>>& score_and_correct,
                        int num_queries) {
  double area = 0.0;
  double last_recall = 0.0;
  for (const PrecisionRecallPoint& point : PrecisionRecallCurve(score_and_correct, num_queries)) {
    area += point.precision * (point.recall - last_recall);
    last_recall = point.recall;
  }
  return area;
}

}  // namespace cairn
