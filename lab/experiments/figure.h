// Figures of experiments. A figure is a gnuplot script that contains its data; gnuplot renders it
// if installed.
#ifndef CAIRN_LAB_EXPERIMENTS_FIGURE_H_
#define CAIRN_LAB_EXPERIMENTS_FIGURE_H_

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
  std::string name;  // File name without extension.
  std::string title;
  std::string x_label;
  std::string y_label;
  bool log_x = false;
  bool log_y = false;
  // Labels of x = 0, 1, ...; empty if x is a number.
  std::vector<std::string> x_names = {};
  std::vector<FigureSeries> series = {};
};

// Returns the script that draws `<name>.svg` and `<name>.png` in its working directory. Leaves out
// points whose x or y is not finite. Depends on the figure alone.
std::string GnuplotScript(const Figure& figure);

// Writes `<name>.gp` to `folder` and runs gnuplot there. Returns true if the pictures exist, and
// false if gnuplot is not installed or fails. Throws Error(kIo) if the script cannot be written.
bool WriteFigure(const Figure& figure, const std::string& folder);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_FIGURE_H_
