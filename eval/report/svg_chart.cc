#include "eval/report/svg_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "eval/pictures/html_text.h"

namespace cairn {
namespace {

constexpr double kChartWidthPx = 460.0, kChartHeightPx = 300.0;
constexpr double kLeftPx = 54.0, kRightPx = 12.0, kTopPx = 34.0, kBottomPx = 44.0;

double ShareOf(const ChartAxis& axis, double value) {
  if (!axis.is_log) {
    return (value - axis.low) / (axis.high - axis.low);
  }
  const double positive = std::max(value, 1e-12);
  return std::log(positive / axis.low) / std::log(axis.high / axis.low);
}

}  // namespace

SvgChart::SvgChart(std::string description, ChartAxis x, ChartAxis y)
    : description_(std::move(description)), x_(std::move(x)), y_(std::move(y)) {}

double SvgChart::PixelX(double x) const {
  return kLeftPx + ShareOf(x_, x) * (kChartWidthPx - kLeftPx - kRightPx);
}

double SvgChart::PixelY(double y) const {
  return kChartHeightPx - kBottomPx - ShareOf(y_, y) * (kChartHeightPx - kTopPx - kBottomPx);
}

void SvgChart::Curve(const std::vector<ChartPoint>& points, int series) {
  if (points.empty()) {
    return;
  }
  std::string line, above, below;
  for (const ChartPoint& point : points) {
    line += fmt::format("{:.1f},{:.1f} ", PixelX(point.x), PixelY(point.y));
    above += fmt::format("{:.1f},{:.1f} ", PixelX(point.x), PixelY(point.high));
    below = fmt::format("{:.1f},{:.1f} ", PixelX(point.x), PixelY(point.low)) + below;
  }
  marks_ += fmt::format("<polygon class=\"band s{0}\" points=\"{1}{2}\"/>\n", series, above, below);
  marks_ += fmt::format("<polyline class=\"line s{}\" points=\"{}\"/>\n", series, line);
}

void SvgChart::Bars(const std::vector<ChartPoint>& points, int series) {
  for (const ChartPoint& point : points) {
    const double x = PixelX(point.x);
    marks_ += fmt::format(
        "<line class=\"line s{0}\" x1=\"{1:.1f}\" x2=\"{1:.1f}\" y1=\"{2:.1f}\" y2=\"{3:.1f}\"/>"
        "<circle class=\"dot s{0}\" cx=\"{1:.1f}\" cy=\"{4:.1f}\" r=\"4\"/>\n",
        series, x, PixelY(point.low), PixelY(point.high), PixelY(point.y));
  }
}

void SvgChart::Reference(double x0, double y0, double x1, double y1, const std::string& label) {
  marks_ += fmt::format(
      "<line class=\"reference\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>",
      PixelX(x0), PixelY(y0), PixelX(x1), PixelY(y1));
  marks_ +=
      fmt::format("<text class=\"note\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n",
                  PixelX(x1) - 4.0, PixelY(y1) + 14.0, HtmlText(label));
}

void SvgChart::Legend(const std::string& text, int series) {
  const double x = kLeftPx + 150.0 * num_legends_++;
  legend_ += fmt::format(
      "<rect class=\"dot s{}\" x=\"{:.0f}\" y=\"10\" width=\"14\" height=\"4\"/>"
      "<text x=\"{:.0f}\" y=\"16\">{}</text>\n",
      series, x, x + 20.0, HtmlText(text));
}

std::string SvgChart::Axes() const {
  const double bottom = kChartHeightPx - kBottomPx, right = kChartWidthPx - kRightPx;
  std::string axes;
  for (const double tick : x_.ticks) {
    axes += fmt::format(
        "<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/>"
        "<text x=\"{0:.1f}\" y=\"{3}\" text-anchor=\"middle\">{4:g}</text>\n",
        PixelX(tick), kTopPx, bottom, bottom + 16.0, tick);
  }
  for (const double tick : y_.ticks) {
    axes += fmt::format(
        "<line class=\"grid\" x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\"/>"
        "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:g}</text>\n",
        kLeftPx, right, PixelY(tick), kLeftPx - 6.0, PixelY(tick) + 4.0, tick);
  }
  axes += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                      0.5 * (kLeftPx + right), kChartHeightPx - 8.0, HtmlText(x_.title));
  axes += fmt::format(
      "<text transform=\"translate(13 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
      0.5 * (kTopPx + bottom), HtmlText(y_.title));
  return axes;
}

std::string SvgChart::ToSvg() const {
  return fmt::format(
      "<svg class=\"chart\" viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"{2}\">\n{3}"
      "<svg x=\"{4}\" y=\"{5}\" width=\"{6}\" height=\"{7}\" viewBox=\"{4} {5} {6} "
      "{7}\">\n{8}</svg>\n"
      "<rect class=\"frame\" x=\"{4}\" y=\"{5}\" width=\"{6}\" height=\"{7}\"/>\n{9}</svg>\n",
      kChartWidthPx, kChartHeightPx, HtmlText(description_), Axes(), kLeftPx, kTopPx,
      kChartWidthPx - kLeftPx - kRightPx, kChartHeightPx - kTopPx - kBottomPx, marks_, legend_);
}

}  // namespace cairn
