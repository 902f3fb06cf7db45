// Runs queries and measures the answers: recall, medians, average precision, latency.
//
// docs/math/metrics.md defines the measures.
#ifndef CAIRN_EVAL_EVALUATION_H_
#define CAIRN_EVAL_EVALUATION_H_

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/angles.h"
#include "engine/query/localize_result.h"
#include "eval/eval_query.h"
#include "eval/evaluation_bootstrap.h"

namespace cairn {

// One answer compared with its reference.
struct EvalAnswer {
  std::string name;
  LocalizeResult result;
  double position_error_m = 0.0;    // Distance between camera centers; infinite if not localized.
  double rotation_error_rad = 0.0;  // Infinite if not localized.
  // The 68 % radii that the answer states in the frame of the reference: in the map or on Earth.
  double position_accuracy_m = 0.0;
  double rotation_accuracy_rad = 0.0;
};

struct RecallThreshold {
  double position_m;
  double rotation_rad;
};

// Errors up to which an answer counts as correct in the average precision: 3 m, 10 degrees.
inline constexpr RecallThreshold kCorrect = {3.0, 10.0 * kRadPerDeg};

// False for an answer without a pose.
bool IsWithin(const EvalAnswer& answer, const RecallThreshold& threshold);

// The precision, and the recall over all queries, when all responses with at least this score are
// accepted.
struct PrecisionRecallPoint {
  double score = 0.0;
  double precision = 0.0;
  double recall = 0.0;
};

// Percentiles, interpolated linearly between the two nearest ranks; zero if there are no values.
struct Percentiles {
  double p50 = 0.0, p90 = 0.0, p99 = 0.0, max = 0.0;
};

struct EvalReport {
  std::vector<EvalAnswer> answers;
  int num_queries = 0;
  int num_localized = 0;
  // Over all queries, at (0.25 m, 2 deg), (0.5 m, 5 deg), (3 m, 10 deg) and (5 m, 10 deg).
  std::vector<std::pair<RecallThreshold, Interval>> recalls;
  Interval median_position_error_m;  // Over localized queries.
  Interval median_rotation_error_rad;
  // Shares of localized queries whose errors are within the radii that the answers state, each with
  // that of its reference in quadrature; 0.68 if the answers know their accuracy.
  Interval position_coverage;
  Interval rotation_coverage;
  Interval
      average_precision;  // Responses are ranked by score and correct within 3 m and 10 degrees.
  std::vector<PrecisionRecallPoint>
      precision_recall;                    // The average precision is the area under this curve.
  std::vector<Percentiles> stage_seconds;  // Indexed by Stage.
  Percentiles total_seconds;
};

// The precision-recall curve of responses (score, correct). The curve has one point for each
// distinct score, from the highest score to the lowest, so recall never falls. `num_queries` is at
// least the number of responses.
std::vector<PrecisionRecallPoint> PrecisionRecallCurve(
    const std::vector<std::pair<double, bool>>& score_and_correct, int num_queries);

// Average precision as defined in the paper (section "Evaluation metric and approach"): the area
// under precision over recall, with responses ranked by score. Recall is counted over
// `num_queries`, so a query without an answer is never recalled. Responses with equal scores are
// accepted together.
double AveragePrecision(const std::vector<std::pair<double, bool>>& score_and_correct,
                        int num_queries);

// Measures given results. results[i] answers queries[i].
EvalReport MeasureResults(const std::vector<EvalQuery>& queries,
                          std::vector<LocalizeResult> results);

using Localize = std::function<LocalizeResult(const EvalQuery&)>;

// Runs the queries one after the other and measures the answers. `progress` may be empty.
EvalReport Evaluate(const std::vector<EvalQuery>& queries, const Localize& localize,
                    const std::function<void(int done, int total)>& progress);

std::string ReportAsText(const EvalReport& report);
// Undefined values (errors of queries without an answer, medians without values) are null.
std::string ReportAsJson(const EvalReport& report);
// A header line and one line for each answer. Undefined values are empty.
std::string ReportAsCsv(const EvalReport& report);
// A header line and one line for each inlier of an answer, as data for fitting EvidenceModel.
// report.answers[i] answers queries[i].
std::string MatchesAsCsv(const std::vector<EvalQuery>& queries, const EvalReport& report);

}  // namespace cairn

#endif  // CAIRN_EVAL_EVALUATION_H_
