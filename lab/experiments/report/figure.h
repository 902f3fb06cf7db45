// Figures of experiments: a gnuplot script that holds its data, rendered where gnuplot is
// installed.
#ifndef CAIRN_LAB_EXPERIMENTS_REPORT_FIGURE_H_
#define CAIRN_LAB_EXPERIMENTS_REPORT_FIGURE_H_

#include <string>
#include <vector>

#include "eval/evaluation_bootstrap.h"

namespace cairn {

struct FigurePoint {
  double x = 0.0;
  Interval y;  // Drawn with an error bar.
};

struct FigureSeries {
  std::string label;
  std::vector<FigurePoint> points;
};

struct Figure {
  std::string name;  // File name without ending.
  std::string title;
  std::string x_label;
  std::string y_label;
  bool log_x = false;
  bool log_y = false;
  // Names of x = 0, 1, ...; empty if x is a number.
  std::vector<std::string> x_names = {};
  std::vector<FigureSeries> series = {};
};

// The script that draws `<name>.svg` and `<name>.png` into its working directory. Points whose x or
// y is not finite are left out. Depends on the figure alone.
std::string GnuplotScript(const Figure& figure);

// Writes `<name>.gp` into `folder` and runs gnuplot there. Returns whether the pictures are there;
// false if gnuplot is not installed or fails. Throws Error(kIo) if the script cannot be written.
bool WriteFigure(const Figure& figure, const std::string& folder);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_REPORT_FIGURE_H_
