#include "eval/report/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "core/images/gray_image.h"
#include "core/wire/base64.h"
#include "eval/pictures/html_text.h"
#include "eval/pictures/pictures.h"
#include "eval/report/plan_svg.h"
#include "eval/report/report_charts.h"
#include "eval/report/report_style.h"
#include "eval/report/svg_chart.h"

namespace cairn {
namespace {

constexpr size_t kNumWorst = 10;
// Rows of the table, beside those of the worst; answers.csv has all.
constexpr size_t kMaxRows = 2000;

// "0.034 m", or a dash if there is no such number.
std::string Number(double value, int digits, const char* unit) {
  return std::isfinite(value) ? fmt::format("{:.{}f}{}", value, digits, unit) : "–";
}

std::string Measured(const char* what, const Interval& interval, double scale, int digits,
                     const char* unit) {
  const std::string range = std::isfinite(interval.low)
                                ? fmt::format("{} to {}", Number(scale * interval.low, digits, ""),
                                              Number(scale * interval.high, digits, unit))
                                : "";
  return fmt::format("<tr><th>{}</th><td>{}</td><td>{}</td></tr>\n", what,
                     Number(scale * interval.value, digits, unit), range);
}

std::string Measures(const EvalReport& report) {
  std::string table =
      "<table class=\"measures\"><thead><tr><th></th><td>value</td><td>95 % interval</td></tr>"
      "</thead>\n";
  for (const auto& [threshold, recall] : report.recalls) {
    const std::string what = fmt::format("recall at {:g} m, {:g}°", threshold.position_m,
                                         kDegPerRad * threshold.rotation_rad);
    table += Measured(what.c_str(), recall, 100.0, 1, " %");
  }
  table += Measured("median position error", report.median_position_error_m, 1.0, 4, " m");
  table += Measured("median rotation error", report.median_rotation_error_rad, kDegPerRad, 4, "°");
  table += Measured("positions in 68 % radius", report.position_coverage, 100.0, 1, " %");
  table += Measured("rotations in 68 % radius", report.rotation_coverage, 100.0, 1, " %");
  table += Measured("average precision", report.average_precision, 1.0, 3, "");
  return table + "</table>\n";
}

std::string Grades(const EvalReport& report) {
  std::string list = "<p class=\"grades\">";
  for (const AnswerGrade grade : {AnswerGrade::kFine, AnswerGrade::kGood, AnswerGrade::kFair,
                                  AnswerGrade::kWrong, AnswerGrade::kNone}) {
    const auto num =
        std::count_if(report.answers.begin(), report.answers.end(),
                      [&](const EvalAnswer& answer) { return GradeOf(answer) == grade; });
    list += fmt::format(
        "<span class=\"{0}\"><svg width=\"14\" height=\"14\" aria-hidden=\"true\">"
        "<circle class=\"answer\" cx=\"7\" cy=\"7\" r=\"5\"/></svg> {1} {2}</span> ",
        GradeClass(grade), num, GradeText(grade));
  }
  return list + "</p>\n";
}

// Wrong answers first, the farthest first; then queries without an answer; then the rest.
std::vector<size_t> WorstFirst(const EvalReport& report) {
  const auto rank = [&](size_t idx) {
    const EvalAnswer& answer = report.answers[idx];
    const int kind = !answer.result.localized ? 1 : IsWithin(answer, kCorrect) ? 2 : 0;
    return std::pair(kind, -answer.position_error_m);
  };
  std::vector<size_t> order(report.answers.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return rank(a) < rank(b); });
  return order;
}

// What is known of a query without its photo: its keypoints, and the inliers among them.
std::string KeypointsAsSvg(const EvalQuery& query, const LocalizeResult& result) {
  const Camera& camera = query.query.camera;
  std::string dots = "<path class=\"landmarks\" stroke-width=\"3\" d=\"";
  for (const Keypoint& keypoint : query.query.features.keypoints) {
    dots += fmt::format("M{:.0f} {:.0f}h1", keypoint.x_px, keypoint.y_px);
  }
  dots += "\"/><path class=\"inliers\" d=\"";
  for (const LocalizeMatch& match : result.matches) {
    if (match.camera_idx == 0) {
      dots += fmt::format("M{:.1f} {:.1f}h0", match.pixel.x(), match.pixel.y());
    }
  }
  return fmt::format(
      "<svg class=\"frameless\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"Keypoints and "
      "inliers of {}\">{}\"/></svg>",
      camera.width_px(), camera.height_px(), HtmlText(query.name), dots);
}

std::string Picture(const EvalQuery& query, const LocalizeResult& result) {
  if (query.image_path.empty()) {
    return KeypointsAsSvg(query, result);
  }
  try {
    const std::vector<uint8_t> jpeg =
        MatchesAsJpeg(ReadGrayImage(query.image_path), query.query, result);
    return fmt::format(
        "<img alt=\"Keypoints and inliers of {}\" src=\"data:image/jpeg;base64,{}\">",
        HtmlText(query.name), EncodeBase64(jpeg));
  } catch (const Error& error) {  // Gone since it was sent; the report is worth having without it.
    return fmt::format("<p class=\"note\">{}</p>{}", HtmlText(error.what()),
                       KeypointsAsSvg(query, result));
  }
}

std::string Sentence(const EvalAnswer& answer) {
  const LocalizeResult& result = answer.result;
  if (!result.localized) {
    return fmt::format("not localized: {}. {} of {} keypoints matched.",
                       NotLocalizedReasonName(result.reason), result.counters.num_matches,
                       result.counters.num_keypoints);
  }
  return fmt::format(
      "{} and {} from the truth; stated {} and {} (68 %), confidence {}; {} inliers of {} "
      "keypoints.",
      Number(answer.position_error_m, 3, " m"),
      Number(kDegPerRad * answer.rotation_error_rad, 3, "°"),
      Number(answer.position_accuracy_m, 3, " m"),
      Number(kDegPerRad * answer.rotation_accuracy_rad, 3, "°"), Number(result.confidence, 3, ""),
      result.matches.size(), result.counters.num_keypoints);
}

std::string Worst(const std::vector<EvalQuery>& queries, const EvalReport& report) {
  const std::vector<size_t> order = WorstFirst(report);
  std::string figures;
  for (size_t i = 0; i < std::min(order.size(), kNumWorst); ++i) {
    const size_t idx = order[i];
    const EvalAnswer& answer = report.answers[idx];
    figures += fmt::format(
        "<figure id=\"w{0}\" class=\"{1}\">{2}<figcaption><a href=\"#q{0}\">{3}</a> {4}"
        "</figcaption></figure>\n",
        idx, GradeClass(GradeOf(answer)), Picture(queries[idx], answer.result),
        HtmlText(answer.name), HtmlText(Sentence(answer)));
  }
  return figures;
}

std::string Table(const EvalReport& report) {
  const std::vector<size_t> order = WorstFirst(report);
  const auto end_of_worst = order.begin() + static_cast<int64_t>(std::min(order.size(), kNumWorst));
  std::string table =
      "<table class=\"all\"><thead><tr><th>query</th><th>answer</th><td>error, m</td><td>error, "
      "°</td><td>stated, m</td><td>stated, °</td><td>confidence</td><td>inliers</td><td>ms</td>"
      "</tr></thead>\n";
  for (size_t i = 0; i < report.answers.size(); ++i) {
    const EvalAnswer& answer = report.answers[i];
    const LocalizeResult& result = answer.result;
    const bool has_picture = std::find(order.begin(), end_of_worst, i) != end_of_worst;
    if (i >= kMaxRows && !has_picture) {
      continue;
    }
    const std::string name = HtmlText(answer.name);
    const auto if_localized = [&](double value, int digits) {
      return result.localized ? Number(value, digits, "") : "–";
    };
    table += fmt::format(
        "<tr id=\"q{}\" class=\"{}\"><th>{}</th><td class=\"mark\">{}</td><td>{}</td><td>{}</td>"
        "<td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.0f}</td></tr>\n",
        i, GradeClass(GradeOf(answer)),
        has_picture ? fmt::format("<a href=\"#w{}\">{}</a>", i, name) : name,
        result.localized ? GradeText(GradeOf(answer)) : NotLocalizedReasonName(result.reason),
        if_localized(answer.position_error_m, 3),
        if_localized(kDegPerRad * answer.rotation_error_rad, 3),
        if_localized(answer.position_accuracy_m, 3),
        if_localized(kDegPerRad * answer.rotation_accuracy_rad, 3),
        if_localized(result.confidence, 3), result.matches.size(),
        1e3 * result.times.total_seconds);
  }
  table += "</table>\n";
  if (report.answers.size() > kMaxRows) {
    table += fmt::format(
        "<p class=\"note\">The first {} of {} queries and the worst; answers.csv has all.</p>\n",
        kMaxRows, report.answers.size());
  }
  return table;
}

std::string Chart(const char* title, const std::string& svg, const char* caption) {
  return fmt::format("<figure><h3>{}</h3>{}<figcaption>{}</figcaption></figure>\n", title, svg,
                     caption);
}

std::string Charts(const EvalReport& report) {
  return "<section class=\"charts\">\n" +
         Chart("Recall over position error", PositionRecallChart(report),
               "The share of all queries with an answer at most so far from the truth.") +
         Chart("Recall over rotation error", RotationRecallChart(report),
               "The same for the rotation.") +
         Chart("Precision over recall", PrecisionChart(report),
               "Answers within 3 m and 10° are right. Each point accepts the answers above one "
               "score.") +
         Chart("Confidence", ConfidenceChart(report),
               "On the dashed line, answers are right as often as they say.") +
         Chart("Stated accuracy", RadiusChart(report),
               "The curves pass the crossing of the dashed lines if answers know their error.") +
         Chart("Times by stage", TimesChart(report), "Median (dark) and 90th percentile (pale).") +
         "</section>\n";
}

std::string Head(const std::string& map_name) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n"
      "<title>Evaluation of {}</title>\n<style>{}</style>\n</head>\n<body>\n",
      HtmlText(map_name), kReportStyle);
}

}  // namespace

std::string MakeReportPage(const std::string& map_name, const MapSnapshot& map,
                           const std::vector<EvalQuery>& queries, const EvalReport& report) {
  const MapInfo info = map.Info();
  std::string page = Head(map_name);
  page += fmt::format(
      "<header><h1>Evaluation of {}</h1>\n<p>Version {} of the map; sessions: {}, tiles: {}, "
      "landmarks: {}. {} of {} queries localized.</p>\n"
      "<nav><a href=\"#measures\">Measures</a> <a href=\"#plan\">Plan</a> <a "
      "href=\"#curves\">Curves</a> <a href=\"#worst\">Worst</a> <a href=\"#all\">All queries</a> "
      "<a href=\"report.json\">report.json</a> <a href=\"answers.csv\">answers.csv</a></nav>"
      "</header>\n<main>\n",
      HtmlText(map_name), Value(info.version), info.num_sessions, info.num_tiles,
      info.num_landmarks, report.num_localized, report.num_queries);
  page += "<h2 id=\"measures\">Measures</h2>\n" + Measures(report) + Grades(report);
  if (report.num_queries > 0) {
    page += "<h2 id=\"plan\">Plan</h2>\n" + PlanAsSvg(map, queries, report);
    page +=
        "<p class=\"note\">Rings are true poses, dots are answers, crosses have no answer; a line "
        "joins the two. Small marks are keyframes and landmarks of the map. Each ring leads to "
        "its query.</p>\n";
    page +=
        "<h2 id=\"curves\">Curves</h2>\n<p class=\"note\">Bands and bars are 95 % "
        "intervals.</p>\n" +
        Charts(report);
    page +=
        "<h2 id=\"worst\">The worst</h2>\n<p class=\"note\">Wrong answers first, then queries "
        "without an answer, then the largest errors.</p>\n" +
        Worst(queries, report);
    page += "<h2 id=\"all\">All queries</h2>\n" + Table(report);
  }
  return page + "</main>\n</body>\n</html>\n";
}

}  // namespace cairn
