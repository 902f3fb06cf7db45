// Formats an evaluation as text, JSON and CSV.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/angles.h"
#include "core/csv.h"
#include "eval/evaluation.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMsFromSeconds = 1e3;
constexpr double kPercent = 100.0;

// JSON has neither infinity nor NaN.
Json NumberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json IntervalAsJson(const Interval& interval, double scale) {
  return {{"value", NumberOrNull(scale * interval.value)},
          {"low", NumberOrNull(scale * interval.low)},
          {"high", NumberOrNull(scale * interval.high)}};
}

Json PercentilesAsJson(const Percentiles& seconds) {
  return {{"p50", kMsFromSeconds * seconds.p50},
          {"p90", kMsFromSeconds * seconds.p90},
          {"p99", kMsFromSeconds * seconds.p99},
          {"max", kMsFromSeconds * seconds.max}};
}

Json AnswerAsJson(const EvalAnswer& answer) {
  const LocalizeResult& result = answer.result;
  Json json = {
      {"name", answer.name},
      {"localized", result.localized},
      {"reason", result.localized ? Json(nullptr) : Json(NotLocalizedReasonName(result.reason))},
      {"position_error_m", NumberOrNull(answer.position_error_m)},
      {"rotation_error_deg", NumberOrNull(kDegPerRad * answer.rotation_error_rad)},
      {"position_accuracy_m", NumberOrNull(answer.position_accuracy_m)},
      {"rotation_accuracy_deg", NumberOrNull(kDegPerRad * answer.rotation_accuracy_rad)},
      {"score", NumberOrNull(result.score)},
      {"confidence", NumberOrNull(result.confidence)},
      {"num_inliers", result.matches.size()},
      {"num_keypoints", result.counters.num_keypoints},
      {"num_matches", result.counters.num_matches}};
  Json& times = json["ms"];
  for (int stage = 0; stage < kNumStages; ++stage) {
    times[StageName(static_cast<Stage>(stage))] = kMsFromSeconds * result.times.seconds[stage];
  }
  times["total"] = kMsFromSeconds * result.times.total_seconds;
  return json;
}

std::string TextLine(const std::string& what, const Interval& interval, double scale, int digits,
                     const char* unit) {
  if (std::isnan(interval.value)) {
    return fmt::format("{:<28}{:>9}\n", what, "-");
  }
  return fmt::format("{:<28}{:>9.{}f} {:<4} [{:.{}f}, {:.{}f}]\n", what, scale * interval.value,
                     digits, unit, scale * interval.low, digits, scale * interval.high, digits);
}

std::string LatencyLine(const char* stage, const Percentiles& seconds) {
  return fmt::format("  {:<12}{:>9.2f}{:>9.2f}{:>9.2f}{:>9.2f}\n", stage,
                     kMsFromSeconds * seconds.p50, kMsFromSeconds * seconds.p90,
                     kMsFromSeconds * seconds.p99, kMsFromSeconds * seconds.max);
}

// For example "2 NO_COVERAGE, 1 TIMEOUT".
std::string ReasonsWhyNot(const EvalReport& report) {
  std::map<std::string, int> count_of_reason;
  for (const EvalAnswer& answer : report.answers) {
    if (!answer.result.localized) {
      ++count_of_reason[NotLocalizedReasonName(answer.result.reason)];
    }
  }
  std::string text;
  for (const auto& [reason, count] : count_of_reason) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, reason);
  }
  return text;
}

}  // namespace

std::string ReportAsText(const EvalReport& report) {
  std::string text =
      fmt::format("{} of {} queries localized", report.num_localized, report.num_queries);
  const std::string reasons = ReasonsWhyNot(report);
  text += reasons.empty() ? "\n\n" : fmt::format("; not: {}\n\n", reasons);
  text += fmt::format("{:<28}{:>9}      {}\n", "", "", "95 % interval");
  for (const auto& [threshold, recall] : report.recalls) {
    const std::string what = fmt::format("recall at {:g} m, {:g} deg", threshold.position_m,
                                         kDegPerRad * threshold.rotation_rad);
    text += TextLine(what, recall, kPercent, 1, "%");
  }
  text += TextLine("median position error", report.median_position_error_m, 1.0, 4, "m");
  text += TextLine("median rotation error", report.median_rotation_error_rad, kDegPerRad, 4, "deg");
  text += TextLine("positions in 68 % radius", report.position_coverage, kPercent, 1, "%");
  text += TextLine("rotations in 68 % radius", report.rotation_coverage, kPercent, 1, "%");
  text += TextLine("average precision", report.average_precision, 1.0, 4, "");
  text += fmt::format("\nlatency, ms   {:>9}{:>9}{:>9}{:>9}\n", "p50", "p90", "p99", "max");
  for (size_t stage = 0; stage < report.stage_seconds.size(); ++stage) {
    text += LatencyLine(StageName(static_cast<Stage>(stage)), report.stage_seconds[stage]);
  }
  return text + LatencyLine("total", report.total_seconds);
}

std::string ReportAsJson(const EvalReport& report) {
  Json json = {{"num_queries", report.num_queries}, {"num_localized", report.num_localized}};
  Json& recalls = json["recalls"] = Json::array();
  for (const auto& [threshold, recall] : report.recalls) {
    Json entry = {{"position_m", threshold.position_m},
                  {"rotation_deg", kDegPerRad * threshold.rotation_rad}};
    entry.update(IntervalAsJson(recall, 1.0));
    recalls.push_back(std::move(entry));
  }
  json["median_position_error_m"] = IntervalAsJson(report.median_position_error_m, 1.0);
  json["median_rotation_error_deg"] = IntervalAsJson(report.median_rotation_error_rad, kDegPerRad);
  json["position_coverage"] = IntervalAsJson(report.position_coverage, 1.0);
  json["rotation_coverage"] = IntervalAsJson(report.rotation_coverage, 1.0);
  json["average_precision"] = IntervalAsJson(report.average_precision, 1.0);
  Json& curve = json["precision_recall"] = Json::array();
  for (const PrecisionRecallPoint& point : report.precision_recall) {
    curve.push_back(
        {{"score", point.score}, {"precision", point.precision}, {"recall", point.recall}});
  }
  Json& latency = json["latency_ms"];
  for (size_t stage = 0; stage < report.stage_seconds.size(); ++stage) {
    latency[StageName(static_cast<Stage>(stage))] = PercentilesAsJson(report.stage_seconds[stage]);
  }
  latency["total"] = PercentilesAsJson(report.total_seconds);
  Json& answers = json["answers"] = Json::array();
  for (const EvalAnswer& answer : report.answers) {
    answers.push_back(AnswerAsJson(answer));
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string ReportAsCsv(const EvalReport& report) {
  std::string text =
      "name,localized,reason,position_error_m,rotation_error_deg,score,confidence,num_inliers,"
      "position_accuracy_m,rotation_accuracy_deg,prior_disagrees,focal_px,focal_disagrees,"
      "false_alarm_rate";
  for (int stage = 0; stage < kNumStages; ++stage) {
    text += fmt::format(",{}_ms", StageName(static_cast<Stage>(stage)));
  }
  text += ",total_ms\n";
  for (const EvalAnswer& answer : report.answers) {
    const LocalizeResult& result = answer.result;
    text += fmt::format(
        "{},{},{},{},{},{},{},{},{},{},{},{},{},{}", CsvText(answer.name), result.localized ? 1 : 0,
        result.localized ? "" : NotLocalizedReasonName(result.reason),
        CsvNumber(answer.position_error_m), CsvNumber(kDegPerRad * answer.rotation_error_rad),
        CsvNumber(result.score), CsvNumber(result.confidence), result.matches.size(),
        result.localized ? CsvNumber(answer.position_accuracy_m) : "",
        result.localized ? CsvNumber(kDegPerRad * answer.rotation_accuracy_rad) : "",
        result.localized ? (result.prior_disagrees ? "1" : "0") : "",
        result.camera ? CsvNumber(result.camera->camera.focal_px()) : "",
        result.camera ? (result.camera->focal_disagrees ? "1" : "0") : "",
        result.localized ? CsvNumber(result.false_alarm_rate) : "");
    for (const double seconds : result.times.seconds) {
      text += "," + CsvNumber(kMsFromSeconds * seconds);
    }
    text += "," + CsvNumber(kMsFromSeconds * result.times.total_seconds) + "\n";
  }
  return text;
}

std::string MatchesAsCsv(const std::vector<EvalQuery>& queries, const EvalReport& report) {
  std::string text =
      "name,score,position_error_m,rotation_error_deg,focal_px,error_px,keypoint_scale_px,"
      "landmark_sigma_px,sq_distance,log_size,orientation_rad,azimuth_rad,right_probability\n";
  for (size_t i = 0; i < report.answers.size(); ++i) {
    const EvalAnswer& answer = report.answers[i];
    const std::string of_answer = fmt::format(
        "{},{},{},{},{}", CsvText(answer.name), CsvNumber(answer.result.score),
        CsvNumber(answer.position_error_m), CsvNumber(kDegPerRad * answer.rotation_error_rad),
        CsvNumber(queries[i].query.camera.focal_px()));
    for (const LocalizeMatch& match : answer.result.matches) {
      const InlierTraits& traits = match.traits;
      text += fmt::format("{},{:.5g},{:.5g},{:.5g},{:.5g},{:.5g},{:.5g},{:.5g},{:.5g}\n", of_answer,
                          traits.error_px, traits.keypoint_scale_px, traits.landmark_sigma_px,
                          traits.sq_distance, traits.log_size, traits.orientation_rad,
                          traits.azimuth_rad, match.right_probability);
    }
  }
  return text;
}

}  // namespace cairn
