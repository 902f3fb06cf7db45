// Charts as SVG inside of a page; the page's style sheet colors them by class.
#ifndef CAIRN_EVAL_REPORT_SVG_CHART_H_
#define CAIRN_EVAL_REPORT_SVG_CHART_H_

#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// An axis that shows [low, high], with a grid line and a label at each tick.
struct ChartAxis {
  std::string title;
  double low = 0.0, high = 1.0;
  bool is_log = false;
  std::vector<double> ticks;
};

// A value with its 95 % interval.
struct ChartPoint {
  double x = 0.0, y = 0.0, low = 0.0, high = 0.0;
};

// Collects marks and draws them in order. Marks outside of the axes are clipped. `series` is 1 to 4
// and selects a color that the style sheet has for both schemes.
class SvgChart {
 public:
  // `description` says in a sentence what the chart shows, for readers who do not see it.
  SvgChart(std::string description, ChartAxis x, ChartAxis y);

  // A line through the points in a band of their intervals.
  void Curve(const std::vector<ChartPoint>& points, int series);
  // Dots with bars of their intervals.
  void Bars(const std::vector<ChartPoint>& points, int series);
  // A dashed line, such as what a perfect answer would give, with a label at its end.
  void Reference(double x0, double y0, double x1, double y1, const std::string& label);
  // The next line of the legend, which stands above the chart and covers nothing.
  void Legend(const std::string& text, int series);

  std::string ToSvg() const;

 private:
  double PixelX(double x) const;
  double PixelY(double y) const;
  std::string Axes() const;

  std::string description_;
  ChartAxis x_, y_;
  std::string marks_, legend_;
  int num_legends_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_EVAL_REPORT_SVG_CHART_H_
