#include "eval/report/report_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "eval/report/svg_chart.h"

namespace cairn {
namespace {

// A little above 1, so that curves at 1 are seen whole.
constexpr double kTop = 1.03;

const std::vector<double> kShares = {0.0, 0.2, 0.4, 0.6, 0.8, 1.0};

ChartPoint Share(double x, int num_yes, int num) {
  const Interval share = WilsonInterval(num_yes, num);
  return {x, share.value, share.low, share.high};
}

int CountIf(const EvalReport& report, const std::function<bool(const EvalAnswer&)>& is) {
  return static_cast<int>(std::count_if(report.answers.begin(), report.answers.end(), is));
}

// The share of queries whose error is at most x, at 60 steps of a logarithmic axis.
std::vector<ChartPoint> RecallCurve(const EvalReport& report, double EvalAnswer::*error,
                                    const ChartAxis& axis, double unit) {
  constexpr int kSteps = 60;
  std::vector<ChartPoint> points;
  for (int step = 0; step <= kSteps; ++step) {
    const double x = axis.low * std::pow(axis.high / axis.low, double(step) / kSteps);
    const int within =
        CountIf(report, [&](const EvalAnswer& answer) { return answer.*error * unit <= x; });
    points.push_back(Share(x, within, report.num_queries));
  }
  return points;
}

std::string RecallChart(const EvalReport& report, double EvalAnswer::*error, double unit,
                        const char* description, ChartAxis axis) {
  const std::vector<ChartPoint> curve = RecallCurve(report, error, axis, unit);
  SvgChart chart(description, std::move(axis), {"share of queries", 0.0, kTop, false, kShares});
  chart.Curve(curve, 1);
  return chart.ToSvg();
}

std::vector<ChartPoint> RadiusCurve(const EvalReport& report, double EvalAnswer::*error,
                                    double EvalAnswer::*radius, double high) {
  constexpr int kSteps = 60;
  std::vector<ChartPoint> points;
  for (int step = 0; step <= kSteps; ++step) {
    const double x = high * step / kSteps;
    const int within = CountIf(report, [&](const EvalAnswer& answer) {
      return answer.result.localized && answer.*error <= x * (answer.*radius);
    });
    points.push_back(Share(x, within, report.num_localized));
  }
  return points;
}

}  // namespace

std::string PositionRecallChart(const EvalReport& report) {
  return RecallChart(
      report, &EvalAnswer::position_error_m, 1.0,
      "Share of queries within a position error, over the error",
      {"position error, meters", 0.001, 10.0, true, {0.001, 0.01, 0.1, 0.25, 1.0, 3.0, 10.0}});
}

std::string RotationRecallChart(const EvalReport& report) {
  return RecallChart(
      report, &EvalAnswer::rotation_error_rad, kDegPerRad,
      "Share of queries within a rotation error, over the error",
      {"rotation error, degrees", 0.001, 20.0, true, {0.001, 0.01, 0.1, 0.5, 2.0, 5.0, 20.0}});
}

std::string PrecisionChart(const EvalReport& report) {
  SvgChart chart("Precision over recall, by the lowest score of an answer",
                 {"recall", 0.0, kTop, false, kShares}, {"precision", 0.0, kTop, false, kShares});
  std::vector<ChartPoint> points;
  for (const PrecisionRecallPoint& point : report.precision_recall) {
    const double right = point.recall * report.num_queries;
    const int accepted =
        point.precision > 0.0 ? static_cast<int>(std::lround(right / point.precision)) : 0;
    if (accepted > 0) {
      points.push_back(Share(point.recall, static_cast<int>(std::lround(right)), accepted));
    }
  }
  if (points.size() == 1) {
    chart.Bars(points, 1);
  }
  chart.Curve(points, 1);
  return chart.ToSvg();
}

std::string ConfidenceChart(const EvalReport& report) {
  constexpr int kBins = 10;
  SvgChart chart("Share of right answers over the confidence that they state",
                 {"stated confidence", 0.0, kTop, false, kShares},
                 {"share of right answers", 0.0, kTop, false, kShares});
  std::vector<ChartPoint> points;
  for (int bin = 0; bin < kBins; ++bin) {
    double sum = 0.0;
    int num = 0, num_right = 0;
    for (const EvalAnswer& answer : report.answers) {
      const double confidence = answer.result.confidence;
      const int of_answer = std::clamp(static_cast<int>(confidence * kBins), 0, kBins - 1);
      if (answer.result.localized && of_answer == bin) {
        sum += confidence;
        ++num;
        num_right += IsWithin(answer, kCorrect) ? 1 : 0;
      }
    }
    if (num > 0) {
      points.push_back(Share(sum / num, num_right, num));
    }
  }
  chart.Reference(0.0, 0.0, 1.0, 1.0, "");
  chart.Bars(points, 1);
  return chart.ToSvg();
}

std::string RadiusChart(const EvalReport& report) {
  constexpr double kHigh = 4.0;
  SvgChart chart("Share of answers within a multiple of the stated 68 % radius",
                 {"multiple of the stated radius", 0.0, kHigh, false, {0.0, 1.0, 2.0, 3.0, 4.0}},
                 {"share of answers", 0.0, kTop, false, kShares});
  if (report.num_localized > 0) {
    chart.Reference(0.0, 0.68, kHigh, 0.68, "68 %");
    chart.Reference(1.0, 0.0, 1.0, 1.0, "");
    chart.Curve(
        RadiusCurve(report, &EvalAnswer::position_error_m, &EvalAnswer::position_accuracy_m, kHigh),
        1);
    chart.Curve(RadiusCurve(report, &EvalAnswer::rotation_error_rad,
                            &EvalAnswer::rotation_accuracy_rad, kHigh),
                2);
    chart.Legend("position", 1);
    chart.Legend("rotation", 2);
  }
  return chart.ToSvg();
}

std::string TimesChart(const EvalReport& report) {
  constexpr double kRowPx = 30.0, kLabelPx = 96.0, kWidthPx = 460.0, kValuePx = 130.0;
  std::vector<std::pair<std::string, Percentiles>> rows;
  for (size_t stage = 0; stage < report.stage_seconds.size(); ++stage) {
    rows.emplace_back(StageName(static_cast<Stage>(stage)), report.stage_seconds[stage]);
  }
  rows.emplace_back("total", report.total_seconds);
  const double px_per_s =
      (kWidthPx - kLabelPx - kValuePx) / std::max(1e-9, report.total_seconds.p90);
  std::string svg = fmt::format(
      "<svg class=\"chart\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"Times by stage: median "
      "and 90th percentile\">\n",
      kWidthPx, kRowPx * static_cast<double>(rows.size()) + 6.0);
  double y = 6.0;
  for (const auto& [name, seconds] : rows) {
    const double p50 = px_per_s * seconds.p50;
    const double p90 = std::min(px_per_s * seconds.p90, kWidthPx - kLabelPx - kValuePx);
    svg += fmt::format(
        "<text x=\"{0}\" y=\"{1}\" text-anchor=\"end\">{2}</text>"
        "<rect class=\"band s1\" x=\"{3}\" y=\"{4}\" width=\"{5:.1f}\" height=\"16\"/>"
        "<rect class=\"dot s1\" x=\"{3}\" y=\"{4}\" width=\"{6:.1f}\" height=\"16\"/>"
        "<text x=\"{7:.1f}\" y=\"{1}\">{8:.1f}, {9:.1f} ms</text>\n",
        kLabelPx - 8.0, y + 13.0, name, kLabelPx, y, std::max(p90, 1.0), std::max(p50, 1.0),
        kLabelPx + p90 + 8.0, 1e3 * seconds.p50, 1e3 * seconds.p90);
    y += kRowPx;
  }
  return svg + "</svg>\n";
}

}  // namespace cairn
