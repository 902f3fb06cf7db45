// Runs queries and measures the answers: recall, medians, average precision, latency.
//
// The definitions are in docs/math/metrics.md.
#ifndef CAIRN_EVAL_EVALUATION_H_
#define CAIRN_EVAL_EVALUATION_H_

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "engine/query/localize_result.h"
#include "eval/eval_query.h"
#include "eval/evaluation_bootstrap.h"

namespace cairn {

// One answer against its reference.
struct EvalAnswer {
  std::string name;
  LocalizeResult result;
  double position_error_m = 0.0;    // Distance of camera centres; infinite if not localized.
  double rotation_error_rad = 0.0;  // Infinite if not localized.
};

struct RecallThreshold {
  double position_m;
  double rotation_rad;
};

// What counts as correct in the average precision: 3 m, 10 degrees.
inline constexpr RecallThreshold kCorrect = {3.0, 0.17453292519943295};

// False for an answer without a pose.
bool IsWithin(const EvalAnswer& answer, const RecallThreshold& threshold);

// Accepting all responses of at least this score gives this precision, and recall over all queries.
struct PrecisionRecallPoint {
  double score = 0.0;
  double precision = 0.0;
  double recall = 0.0;
};

// Linearly interpolated between the two nearest ranks; zero if there is no value.
struct Percentiles {
  double p50 = 0.0, p90 = 0.0, p99 = 0.0, max = 0.0;
};

struct EvalReport {
  std::vector<EvalAnswer> answers;
  int num_queries = 0;
  int num_localized = 0;
  // At (0.25 m, 2 deg), (0.5 m, 5 deg), (3 m, 10 deg), (5 m, 10 deg), over all queries.
  std::vector<std::pair<RecallThreshold, Interval>> recalls;
  Interval median_position_error_m;  // Over localized queries.
  Interval median_rotation_error_rad;
  Interval average_precision;  // Correct within 3 m and 10 degrees, ranked by score.
  std::vector<PrecisionRecallPoint> precision_recall;  // The curve under which it is the area.
  std::vector<Percentiles> stage_seconds;              // Indexed by Stage.
  Percentiles total_seconds;
};

// Responses (score, correct) as a curve: one point per distinct score, from the highest score to
// the lowest, so that recall never falls. `num_queries` is at least the number of responses.
std::vector<PrecisionRecallPoint> PrecisionRecallCurve(
    const std::vector<std::pair<double, bool>>& score_and_correct, int num_queries);

// Average precision as the paper defines it (section "Evaluation metric and approach"): the area
// under precision over recall, responses ranked by score, recall counted over `num_queries` (a
// query without an answer is never recalled). Responses with equal scores are accepted together.
double AveragePrecision(const std::vector<std::pair<double, bool>>& score_and_correct,
                        int num_queries);

// Measures given results; results[i] answers queries[i].
EvalReport MeasureResults(const std::vector<EvalQuery>& queries,
                          std::vector<LocalizeResult> results);

using Localize = std::function<LocalizeResult(const EvalQuery&)>;

// Asks the queries one after the other and measures the answers. `progress` may be empty.
EvalReport Evaluate(const std::vector<EvalQuery>& queries, const Localize& localize,
                    const std::function<void(int done, int total)>& progress);

std::string ReportAsText(const EvalReport& report);
// What cannot be measured (errors of queries without an answer, medians of none) is null.
std::string ReportAsJson(const EvalReport& report);
// One line an answer, with a header line; what cannot be measured is empty.
std::string ReportAsCsv(const EvalReport& report);
// One line an inlier of an answer, with a header line: what EvidenceModel is fitted to.
// report.answers[i] answers queries[i].
std::string MatchesAsCsv(const std::vector<EvalQuery>& queries, const EvalReport& report);

}  // namespace cairn

#endif  // CAIRN_EVAL_EVALUATION_H_
