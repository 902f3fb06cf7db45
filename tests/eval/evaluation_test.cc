#include "eval/evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/angles.h"

namespace cairn {
namespace {

EvalQuery QueryAtOrigin(const std::string& name) {
  EvalQuery query;
  query.name = name;
  query.cam_from_ecef = EcefFromEnu(Geodetic::FromDegrees(47.0, 8.0, 400.0)).Inverse();
  return query;
}

// An answer with these errors.
LocalizeResult AnswerOff(const EvalQuery& query, double position_m, double rotation_rad,
                         double score) {
  LocalizeResult result;
  result.localized = true;
  result.score = score;
  const Rigid3d moved(ExpSo3(Eigen::Vector3d(0.0, rotation_rad, 0.0)),
                      Eigen::Vector3d(0.0, 0.0, position_m));
  result.cam_from_ecef = moved * query.cam_from_ecef;
  result.times.seconds = {0.001, 0.002, 0.003, 0.004, 0.005, 0.006};
  result.times.total_seconds = 0.021;
  return result;
}

LocalizeResult NoAnswer(NotLocalizedReason reason) {
  LocalizeResult result;
  result.reason = reason;
  return result;
}

TEST(AveragePrecision, IsTheAreaUnderTheRankedResponses) {
  // Five queries, one unanswered: (1/1 + 2/3 + 3/4) / 5.
  EXPECT_NEAR(AveragePrecision({{8.0, false}, {9.0, true}, {6.0, true}, {7.0, true}}, 5),
              (1.0 + 2.0 / 3.0 + 3.0 / 4.0) / 5.0, 1e-12);
}

TEST(AveragePrecision, IsOneIfEveryQueryIsAnsweredRight) {
  EXPECT_DOUBLE_EQ(AveragePrecision({{1.0, true}, {2.0, true}}, 2), 1.0);
}

TEST(AveragePrecision, IsTheShareAnsweredIfAllAnswersAreRight) {
  EXPECT_DOUBLE_EQ(AveragePrecision({{1.0, true}}, 4), 0.25);
}

TEST(AveragePrecision, IsZeroWithoutACorrectResponse) {
  EXPECT_DOUBLE_EQ(AveragePrecision({{1.0, false}}, 2), 0.0);
  EXPECT_DOUBLE_EQ(AveragePrecision({}, 3), 0.0);
}

TEST(AveragePrecision, AcceptsEqualScoresTogether) {
  // Whichever of the two is listed first: precision 1/2 at recall 1/2.
  EXPECT_DOUBLE_EQ(AveragePrecision({{1.0, true}, {1.0, false}}, 2), 0.25);
  EXPECT_DOUBLE_EQ(AveragePrecision({{1.0, false}, {1.0, true}}, 2), 0.25);
}

TEST(Evaluate, MeasuresErrorsOfEachAnswer) {
  const std::vector<EvalQuery> queries = {QueryAtOrigin("a"), QueryAtOrigin("b")};
  const EvalReport report = MeasureResults(
      queries, {AnswerOff(queries[0], 0.125, 0.02, 1.0), NoAnswer(NotLocalizedReason::kTimeout)});
  EXPECT_NEAR(report.answers[0].position_error_m, 0.125, 1e-8);
  EXPECT_NEAR(report.answers[0].rotation_error_rad, 0.02, 1e-8);
  EXPECT_TRUE(std::isinf(report.answers[1].position_error_m));
  EXPECT_TRUE(std::isinf(report.answers[1].rotation_error_rad));
  EXPECT_EQ(report.num_queries, 2);
  EXPECT_EQ(report.num_localized, 1);
}

TEST(Evaluate, CountsRecallOverAllQueries) {
  std::vector<EvalQuery> queries;
  std::vector<LocalizeResult> results;
  const std::vector<std::pair<double, double>> errors = {
      {0.2, 1.0}, {0.2, 3.0}, {0.4, 4.0}, {2.0, 9.0}, {4.0, 1.0}, {20.0, 1.0}, {0.1, 60.0}};
  for (const auto& [position_m, rotation_deg] : errors) {
    queries.push_back(QueryAtOrigin("query"));
    results.push_back(AnswerOff(queries.back(), position_m, rotation_deg * kRadPerDeg, 1.0));
  }
  queries.push_back(QueryAtOrigin("unanswered"));
  results.push_back(NoAnswer(NotLocalizedReason::kNoCoverage));
  const EvalReport report = MeasureResults(queries, std::move(results));
  ASSERT_EQ(report.recalls.size(), 4u);
  EXPECT_DOUBLE_EQ(report.recalls[0].second.value, 1.0 / 8.0);  // 0.25 m, 2 degrees.
  EXPECT_DOUBLE_EQ(report.recalls[1].second.value, 3.0 / 8.0);  // 0.5 m, 5 degrees.
  EXPECT_DOUBLE_EQ(report.recalls[2].second.value, 4.0 / 8.0);  // 3 m, 10 degrees.
  EXPECT_DOUBLE_EQ(report.recalls[3].second.value, 5.0 / 8.0);  // 5 m, 10 degrees.
}

TEST(Evaluate, TakesMediansOfLocalizedQueriesOnly) {
  std::vector<EvalQuery> queries;
  std::vector<LocalizeResult> results;
  for (const double position_m : {0.5, 0.1, 0.2, 0.3}) {
    queries.push_back(QueryAtOrigin("query"));
    results.push_back(AnswerOff(queries.back(), position_m, 0.01 * position_m, 1.0));
  }
  queries.push_back(QueryAtOrigin("unanswered"));
  results.push_back(NoAnswer(NotLocalizedReason::kTooFewInliers));
  const EvalReport report = MeasureResults(queries, std::move(results));
  EXPECT_NEAR(report.median_position_error_m.value, 0.25, 1e-8);
  EXPECT_NEAR(report.median_rotation_error_rad.value, 0.0025, 1e-8);
}

TEST(Evaluate, JudgesRadiiWithThatOfTheReference) {
  std::vector<EvalQuery> queries = {QueryAtOrigin("exact"), QueryAtOrigin("uncertain")};
  queries[1].reference_radius_m = 0.4;
  queries[1].reference_radius_rad = 0.04;
  std::vector<LocalizeResult> results;
  for (EvalQuery& query : queries) {
    query.reference_frame = ReferenceFrame::kMap;
    results.push_back(AnswerOff(query, 0.45, 0.045, 1.0));
    results.back().position_accuracy_m = 0.3;
    results.back().rotation_accuracy_rad = 0.03;
  }
  const EvalReport report = MeasureResults(queries, std::move(results));
  EXPECT_DOUBLE_EQ(report.position_coverage.value, 0.5);
  EXPECT_DOUBLE_EQ(report.rotation_coverage.value, 0.5);
  EXPECT_DOUBLE_EQ(report.answers[1].position_accuracy_m, 0.3);  // What the answer states.
}

TEST(Evaluate, IntervalsHoldTheValueAndShrinkWithoutDoubt) {
  std::vector<EvalQuery> queries;
  std::vector<LocalizeResult> mixed, perfect;
  for (int i = 0; i < 40; ++i) {
    queries.push_back(QueryAtOrigin("query"));
    mixed.push_back(AnswerOff(queries.back(), i % 2 == 0 ? 0.1 : 50.0, 0.0, i));
    perfect.push_back(AnswerOff(queries.back(), 0.1, 0.0, i));
  }
  const Interval half = MeasureResults(queries, std::move(mixed)).recalls[0].second;
  EXPECT_DOUBLE_EQ(half.value, 0.5);
  // The binomial standard deviation is 0.079: the interval is about 0.35 to 0.65.
  EXPECT_NEAR(half.low, 0.35, 0.05);
  EXPECT_NEAR(half.high, 0.65, 0.05);
  const Interval all = MeasureResults(queries, std::move(perfect)).recalls[0].second;
  EXPECT_DOUBLE_EQ(all.low, 1.0);
  EXPECT_DOUBLE_EQ(all.high, 1.0);
}

TEST(Evaluate, InterpolatesLatencyPercentiles) {
  std::vector<EvalQuery> queries;
  std::vector<LocalizeResult> results;
  for (int i = 0; i <= 10; ++i) {
    queries.push_back(QueryAtOrigin("query"));
    results.push_back(AnswerOff(queries.back(), 0.0, 0.0, 1.0));
    results.back().times.seconds[static_cast<int>(Stage::kMatching)] = i;
    results.back().times.total_seconds = 2.0 * i;
  }
  const EvalReport report = MeasureResults(queries, std::move(results));
  const Percentiles& matching = report.stage_seconds[static_cast<int>(Stage::kMatching)];
  EXPECT_DOUBLE_EQ(matching.p50, 5.0);
  EXPECT_DOUBLE_EQ(matching.p90, 9.0);
  EXPECT_DOUBLE_EQ(matching.p99, 9.9);
  EXPECT_DOUBLE_EQ(matching.max, 10.0);
  EXPECT_DOUBLE_EQ(report.total_seconds.p50, 10.0);
}

TEST(Evaluate, AsksEachQueryOnceAndReportsProgress) {
  const std::vector<EvalQuery> queries = {QueryAtOrigin("a"), QueryAtOrigin("b")};
  std::vector<std::string> asked;
  std::vector<std::pair<int, int>> progress;
  Evaluate(
      queries,
      [&](const EvalQuery& query) {
        asked.push_back(query.name);
        return NoAnswer(NotLocalizedReason::kNoCoverage);
      },
      [&](int done, int total) { progress.emplace_back(done, total); });
  EXPECT_THAT(asked, ::testing::ElementsAre("a", "b"));
  EXPECT_THAT(progress, ::testing::ElementsAre(std::pair(1, 2), std::pair(2, 2)));
}

TEST(Report, WithoutQueriesHasNoFigures) {
  const EvalReport report = MeasureResults({}, {});
  EXPECT_TRUE(std::isnan(report.average_precision.value));
  const auto json = nlohmann::json::parse(ReportAsJson(report));
  EXPECT_TRUE(json["average_precision"]["value"].is_null());
  EXPECT_THAT(ReportAsText(report), ::testing::HasSubstr("0 of 0"));
}

EvalReport SmallReport() {
  const std::vector<EvalQuery> queries = {QueryAtOrigin("a, \"quoted\""), QueryAtOrigin("b")};
  return MeasureResults(queries, {AnswerOff(queries[0], 0.5, 2.0 * kRadPerDeg, 12.0),
                                  NoAnswer(NotLocalizedReason::kNoCoverage)});
}

TEST(Report, JsonHoldsFiguresAndAnswers) {
  const auto json = nlohmann::json::parse(ReportAsJson(SmallReport()));
  EXPECT_EQ(json["num_queries"], 2);
  EXPECT_EQ(json["num_localized"], 1);
  EXPECT_DOUBLE_EQ(json["recalls"][1]["value"].get<double>(), 0.5);
  EXPECT_NEAR(json["answers"][0]["rotation_error_deg"].get<double>(), 2.0, 1e-6);
  EXPECT_TRUE(json["answers"][1]["position_error_m"].is_null());
  EXPECT_EQ(json["answers"][1]["reason"], NotLocalizedReasonName(NotLocalizedReason::kNoCoverage));
  EXPECT_NEAR(json["latency_ms"]["total"]["max"].get<double>(), 21.0, 1e-9);
}

TEST(Report, CsvQuotesNamesAndLeavesUnknownsEmpty) {
  const std::string csv = ReportAsCsv(SmallReport());
  EXPECT_THAT(csv, ::testing::HasSubstr("\n\"a, \"\"quoted\"\"\",1,,0.5,2,12,"));
  EXPECT_THAT(
      csv, ::testing::HasSubstr(std::string("\nb,0,") +
                                NotLocalizedReasonName(NotLocalizedReason::kNoCoverage) + ",,,"));
}

TEST(Report, CsvHasAValueOfEachColumn) {
  EvalReport report = SmallReport();
  report.answers[0].name = "a";  // Without a comma.
  std::istringstream csv(ReportAsCsv(report));
  std::string header, row;
  std::getline(csv, header);
  int num_rows = 0;
  for (; std::getline(csv, row); ++num_rows) {
    EXPECT_EQ(std::ranges::count(row, ','), std::ranges::count(header, ',')) << row;
  }
  EXPECT_EQ(num_rows, 2);
}

TEST(Report, TextSaysWhyQueriesFailed) {
  const std::string text = ReportAsText(SmallReport());
  EXPECT_THAT(text, ::testing::HasSubstr("1 of 2 queries localized"));
  EXPECT_THAT(text, ::testing::HasSubstr(std::string("1 ") +
                                         NotLocalizedReasonName(NotLocalizedReason::kNoCoverage)));
  EXPECT_THAT(text, ::testing::HasSubstr("recall at 0.5 m, 5 deg"));
}

}  // namespace
}  // namespace cairn
